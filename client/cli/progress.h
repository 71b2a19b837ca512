#pragma once

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "client/cli/output.h"
#include "client/cpp/watcher.h"

// Shows progress to a waiting user: on stderr, only if that is a terminal, and not with --json or --quiet. It is erased
// from the screen when the work is done.
namespace kerf::cli {

bool is_watched(const Session& session);

// Returns "[####............] 25 %  0:12 left  what". `done`: 0..1. The time left is missing until a second has passed
// and 1 % is done.
std::string progress_line(double done, double elapsed_s, const std::string& what);

// Shows the progress of work that reports it.
class ProgressBar {
 public:
  explicit ProgressBar(const Session& session) : live_(is_watched(session)) {}
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  // Draws at most ten times a second, so it may be called for each change.
  void show(double done, const std::string& what);
  void show(const std::string& what);  // For work without a known end.

 private:
  using Clock = std::chrono::steady_clock;
  // True if the bar is visible and the last drawing is old enough.
  bool is_due();

  bool live_ = false;
  Clock::time_point started_ = Clock::now();
  Clock::time_point drawn_;  // Time of the last drawing; the epoch if there was none.
};

// Shows a call without progress: its name and its time so far, from half a second on.
class WaitingNote {
 public:
  WaitingNote(const Session& session, std::string what);
  ~WaitingNote();
  WaitingNote(const WaitingNote&) = delete;
  WaitingNote& operator=(const WaitingNote&) = delete;

 private:
  void run();

  std::string what_;
  std::mutex mutex_;
  std::condition_variable ended_;
  bool has_ended_ = false;
  std::thread thread_;  // Runs only if the note is visible.
};

// Shows the progress of a StepSheet call, known from the sheet's frames. Make the object before the call and destroy it
// after.
class StepProgress {
 public:
  // `name`: "sheets/demo"; `ticks`: number requested.
  StepProgress(const Session& session, const std::string& name, std::int32_t ticks);
  ~StepProgress();
  StepProgress(const StepProgress&) = delete;
  StepProgress& operator=(const StepProgress&) = delete;

 private:
  void run(const std::string& name, std::int64_t first, std::int32_t ticks);

  ProgressBar bar_;
  std::unique_ptr<client::Client> client_;  // Set only if the bar is visible, as are the next two.
  std::unique_ptr<client::Watcher> watcher_;
  std::thread thread_;
};

}  // namespace kerf::cli
