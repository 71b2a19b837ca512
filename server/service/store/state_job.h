#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "server/service/store/files.h"
#include "server/service/store/row_sums.h"
#include "server/service/store/write_queue.h"

namespace kerf::store {

// Writes the content of a file in pieces, so that other writes have their turn between them. The file has its name only
// once it is whole and synced.
class FileJob {
 public:
  // `folder` contains the file.
  FileJob(Files& files, std::string folder, std::string name, std::string content);
  // Writes one piece, or gives the file its name. Returns true if that was the last step.
  Result<bool> advance();
  // Removes what is written, so that the next step is the first.
  void restart();
  [[nodiscard]] std::int64_t bytes() const { return static_cast<std::int64_t>(content_.size()); }
  // Valid after the last step.
  [[nodiscard]] std::uint32_t sum() const { return sums_.value(); }

 private:
  Files& files_;
  std::string folder_;
  std::string name_;
  std::string content_;
  std::unique_ptr<AppendFile> file_;
  std::size_t written_ = 0;
  PieceSums sums_;
};

// Writes the file of a state.
class StateJob {
 public:
  // Encodes the content of the state; throws std::bad_alloc before it takes anything from `change`.
  StateJob(Files& files, const std::string& folder, StateChange& change, std::int64_t number);
  Result<bool> advance() { return file_.advance(); }
  void restart() { file_.restart(); }
  // Valid after the last step.
  [[nodiscard]] StateInfo info() const;
  void call_durable() const {
    if (durable_) durable_();
  }

 private:
  StateInfo info_;
  FileJob file_;
  host::Journal::Durable durable_;
};

}  // namespace kerf::store
