#include "server/app/file_recording.h"

#include <new>
#include <utility>

#include "server/service/wire/recording_codec.h"

namespace kerf::app {

namespace {

constexpr std::size_t kPieceBytes = 4096;  // Bytes of waiting entries written at once.

}  // namespace

FileRecording::FileRecording(Disk& disk, const host::Clock& clock, RecordingBoard& board, std::string path,
                             std::function<void(const std::string&)> note)
    : disk_(disk), clock_(clock), board_(board), path_(std::move(path)), note_(std::move(note)) {
  ++board_.open;
}

FileRecording::~FileRecording() {
  try {
    if (state_ == State::kPaused) try_a_last_time();
  } catch (const std::bad_alloc&) {
    ++board_.errors;  // The waiting entries are lost. The file is complete up to the last entry written.
  }
  forget_waiting();
  if (state_ != State::kWriting) --board_.stopped;
  --board_.open;
}

void FileRecording::try_a_last_time() {
  const Status written = write_waiting();
  if (written.ok()) return resume();
  ++board_.errors;
  say("ends with its sheet, " + std::to_string(waiting_bytes_) + " bytes short: " + written.error().message);
}

void FileRecording::start(const scene::SheetConfig& config) {
  std::string header = wire::encode_recording_header(config, wire::build_name());
  header_bytes_ = static_cast<std::int64_t>(header.size());
  write(std::move(header));
}

void FileRecording::append(const sheet::RecordedTick& entry) {
  if (state_ != State::kEnded) write(wire::encode_recorded_tick(entry));
}

void FileRecording::end_early(const std::string& why) {
  if (state_ == State::kEnded) return;
  if (state_ == State::kPaused) try_a_last_time();
  if (state_ == State::kWriting) ++board_.stopped;
  state_ = State::kEnded;
  file_.reset();
  forget_waiting();
  say("has ended: " + why + "; the file replays up to its last entry");
}

void FileRecording::write(std::string bytes) {
  const auto count = static_cast<std::int64_t>(bytes.size());
  waiting_bytes_ += count;
  board_.waiting_bytes += count;
  if (!waiting_.empty() && waiting_.back().size() + bytes.size() <= kPieceBytes) {
    waiting_.back() += bytes;
  } else {
    waiting_.push_back(std::move(bytes));
  }
  if (state_ == State::kWriting || clock_.now() >= next_try_ || waits_too_much()) try_to_write();
}

bool FileRecording::waits_too_much() const {
  return waiting_bytes_ > header_bytes_ + kMaxWaitingBytes || board_.waiting_bytes > kMaxAllWaitingBytes;
}

void FileRecording::try_to_write() {
  const Status written = write_waiting();
  if (written.ok()) {
    if (state_ == State::kPaused) resume();
    return;
  }
  ++board_.errors;
  next_try_ = clock_.now() + kRetryInterval;
  if (state_ == State::kWriting) pause(written.error());
  if (waits_too_much()) end();
}

Status FileRecording::write_waiting() {
  if (!file_) {
    KERF_TRY_ASSIGN(file_, disk_.create_file(path_));
  }
  for (; !waiting_.empty(); waiting_.pop_front()) {
    KERF_TRY(file_->append(waiting_.front()));
    const auto count = static_cast<std::int64_t>(waiting_.front().size());
    header_bytes_ = 0;  // It is in the first piece.
    waiting_bytes_ -= count;
    board_.waiting_bytes -= count;
    board_.bytes += count;
  }
  return Nothing{};
}

void FileRecording::pause(const Error& error) {
  state_ = State::kPaused;
  ++board_.stopped;
  say("pauses: " + error.message + "; it retries every second and loses nothing until 1 MiB waits");
}

void FileRecording::resume() {
  state_ = State::kWriting;
  --board_.stopped;
  say("resumes; nothing is missing");
}

void FileRecording::end() {
  state_ = State::kEnded;
  file_.reset();
  forget_waiting();
  say("has ended: too much is waiting; the file replays up to its last entry");
}

void FileRecording::forget_waiting() {
  board_.waiting_bytes -= waiting_bytes_;
  waiting_bytes_ = 0;
  std::deque<std::string>().swap(waiting_);
}

}  // namespace kerf::app
