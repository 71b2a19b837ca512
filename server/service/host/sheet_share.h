#pragma once

#include <atomic>
#include <cstdint>

#include "server/base/result.h"
#include "server/service/host/vertex_budget.h"

namespace kerf::host {

// Holds what one sheet takes of the host, from before it is built until it is gone: vertices of the budget, and the
// need of a worker, see WorkerNeed. Written by one thread at a time, read by any.
class SheetShare {
 public:
  // `taken`: vertices of the sheet that the budget has counted already.
  SheetShare(VertexBudget& budget, std::int64_t taken, std::int64_t need)
      : budget_(budget), vertices_(taken), need_(need) {}
  ~SheetShare() { give_back(); }
  SheetShare(const SheetShare&) = delete;
  SheetShare& operator=(const SheetShare&) = delete;

  [[nodiscard]] std::int64_t vertices() const { return vertices_; }
  [[nodiscard]] std::int64_t need() const { return need_; }

  // Sets the vertices of a sheet just built, which may exceed the number declared before. Errors of
  // VertexBudget::take().
  Status settle(std::int64_t vertices);
  // Sets the present vertices. Never refused: cuts add few vertices, and refusing a cut would be worse than exceeding
  // the limit.
  void set_vertices(std::int64_t vertices);
  void set_need(std::int64_t need) { need_ = need; }
  // Gives everything back, as the sheet is gone.
  void give_back();

 private:
  VertexBudget& budget_;
  std::atomic<std::int64_t> vertices_;
  std::atomic<std::int64_t> need_;
};

}  // namespace kerf::host
