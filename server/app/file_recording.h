#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <string>

#include "server/base/disk.h"
#include "server/core/sheet/recording.h"
#include "server/service/host/clock.h"
#include "server/service/ws/metrics_page.h"

namespace kerf::app {

// Counts all recordings of a server, see ws::RecordingCounts. Thread-safe.
struct RecordingBoard {
  std::atomic<std::int64_t> open{0};
  std::atomic<std::int64_t> stopped{0};
  std::atomic<std::int64_t> waiting_bytes{0};
  std::atomic<std::int64_t> errors{0};
  std::atomic<std::int64_t> bytes{0};

  [[nodiscard]] ws::RecordingCounts read() const { return {open, stopped, waiting_bytes, errors, bytes}; }
};

// Writes a recording file while the sheet runs (format: kerf/v1/run.proto). Appended data is handed to the operating
// system: it survives the process, not the machine.
//
// After a failed write the recording pauses: entries wait in memory. An entry that comes kRetryInterval or more after a
// failure makes it try again. A sleeping or paused sheet has no entries, so it does not retry. If too much waits, the
// recording ends for good. The file has whole entries only, without a gap. Each pause, resumption and early end is one
// line to `note`.
class FileRecording : public sheet::RecordingSink {
 public:
  static constexpr host::Nanoseconds kRetryInterval = std::chrono::seconds(1);
  static constexpr std::int64_t kMaxWaitingBytes = std::int64_t{1} << 20;       // Per recording, without the header.
  static constexpr std::int64_t kMaxAllWaitingBytes = std::int64_t{256} << 20;  // For all recordings on one board.

  // `disk`, `clock` and `board` must outlive this; `note` is called from the sheet's strand and the destructor.
  FileRecording(Disk& disk, const host::Clock& clock, RecordingBoard& board, std::string path,
                std::function<void(const std::string&)> note);
  // Tries a last time to write waiting entries.
  ~FileRecording() override;
  FileRecording(const FileRecording&) = delete;
  FileRecording& operator=(const FileRecording&) = delete;

  void start(const scene::SheetConfig& config) override;
  void append(const sheet::RecordedTick& entry) override;
  void end_early(const std::string& why) override;

 private:
  enum class State { kWriting, kPaused, kEnded };

  void write(std::string bytes);
  [[nodiscard]] bool waits_too_much() const;
  void try_to_write();
  void try_a_last_time();
  Status write_waiting();
  void pause(const Error& error);
  void resume();
  void end();
  void forget_waiting();
  void say(const std::string& what) const { note_("recording " + path_ + " " + what); }

  Disk& disk_;
  const host::Clock& clock_;
  RecordingBoard& board_;
  const std::string path_;
  const std::function<void(const std::string&)> note_;
  State state_ = State::kWriting;
  std::unique_ptr<AppendFile> file_;  // Null: not made yet, or the recording has ended.
  std::deque<std::string> waiting_;   // Whole entries in order, several small ones in one string.
  std::int64_t waiting_bytes_ = 0;
  std::int64_t header_bytes_ = 0;  // Bytes of a header that still waits; 0: it is written.
  host::Nanoseconds next_try_{0};  // Earliest time of the next try while kPaused.
};

}  // namespace kerf::app
