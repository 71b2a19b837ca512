#include "server/service/host/sheet_share.h"

namespace kerf::host {

Status SheetShare::settle(std::int64_t vertices) {
  if (vertices > vertices_) {
    KERF_TRY(budget_.take(vertices - vertices_));
    vertices_ = vertices;
  }
  set_vertices(vertices);
  return Nothing{};
}

void SheetShare::set_vertices(std::int64_t vertices) {
  if (vertices == vertices_) return;
  budget_.change(vertices - vertices_);
  vertices_ = vertices;
}

void SheetShare::give_back() {
  set_vertices(0);
  set_need(0);
}

}  // namespace kerf::host
