#include "server/service/store/state_job.h"

#include <string_view>
#include <utility>

#include "server/service/store/reading.h"
#include "server/service/store/schema.h"

namespace kerf::store {
namespace {

StateInfo info_of(const host::StoredState& state, std::int64_t number) {
  StateInfo info;
  info.sheet = state.sheet;
  info.seq = state.seq;
  info.name = state.name;
  info.number = number;
  info.tick = state.tick;
  info.engine = state.engine;
  info.state_hash = state.state_hash;
  info.continuation_hash = state.continuation_hash;
  return info;
}

}  // namespace

FileJob::FileJob(Files& files, std::string folder, std::string name, std::string content)
    : files_(files), folder_(std::move(folder)), name_(std::move(name)), content_(std::move(content)) {}

Result<bool> FileJob::advance() {
  const std::string path = folder_ + "/" + name_;
  const std::string beside = path + ".new";
  if (file_ == nullptr) {
    KERF_TRY_ASSIGN(file_, files_.create(beside));
    return false;
  }
  if (written_ < content_.size()) {
    const std::string_view piece = std::string_view(content_).substr(written_, kPieceBytes);
    KERF_TRY(file_->append(piece));
    KERF_TRY(file_->sync());
    sums_.add(piece);
    written_ += piece.size();
    return false;
  }
  KERF_TRY(file_->sync());
  KERF_TRY(files_.rename(beside, path));
  KERF_TRY(files_.sync_folder(folder_));
  return true;
}

void FileJob::restart() {
  file_.reset();
  (void)files_.remove(folder_ + "/" + name_ + ".new");  // if this fails, creating the file once more empties it
  written_ = 0;
  sums_ = PieceSums();
}

StateJob::StateJob(Files& files, const std::string& folder, StateChange& change, std::int64_t number)
    : info_(info_of(change.state, number)),
      file_(files, states_path(folder), file_name(info_),
            change.state.encode ? change.state.encode() : std::move(change.state.content)),
      durable_(std::move(change.durable)) {}

StateInfo StateJob::info() const {
  StateInfo info = info_;
  info.bytes = file_.bytes();
  info.content_sum = file_.sum();
  return info;
}

}  // namespace kerf::store
