#pragma once

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "client/cli/output.h"
#include "client/cpp/watcher.h"

// What a person sees who waits: on stderr, only where that is a terminal, and not with --json or --quiet. All of it is
// gone from the screen when the work is done.
namespace kerf::cli {

bool is_watched(const Session& session);

// "[####............] 25 %  0:12 left  what". `done`: 0..1; no time is told before a second has passed and 1 % is done.
std::string progress_line(double done, double elapsed_s, const std::string& what);

// Of work that tells how far it is.
class ProgressBar {
 public:
  explicit ProgressBar(const Session& session) : live_(is_watched(session)) {}
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  // Draws at most ten times a second, so it may be called as often as there is news.
  void show(double done, const std::string& what);
  void show(const std::string& what);  // of work without an end

 private:
  using Clock = std::chrono::steady_clock;
  // Whether there is somebody to see it, and the last one is old enough.
  bool is_due();

  bool live_ = false;
  Clock::time_point started_ = Clock::now();
  Clock::time_point drawn_;  // the epoch: not yet
};

// Of a call that does not: what it is and for how long it has been under way, from half a second on.
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
  std::thread thread_;  // only where somebody watches
};

// Of a StepSheet to come, told by the frames of the sheet: made before the call, gone after it.
class StepProgress {
 public:
  // name: "sheets/demo"; ticks: that it is asked to step.
  StepProgress(const Session& session, const std::string& name, std::int32_t ticks);
  ~StepProgress();
  StepProgress(const StepProgress&) = delete;
  StepProgress& operator=(const StepProgress&) = delete;

 private:
  void run(const std::string& name, std::int64_t first, std::int32_t ticks);

  ProgressBar bar_;
  std::unique_ptr<client::Client> client_;  // only where somebody watches, as the next two
  std::unique_ptr<client::Watcher> watcher_;
  std::thread thread_;
};

}  // namespace kerf::cli
