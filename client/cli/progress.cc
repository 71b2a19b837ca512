#include "client/cli/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include "client/cli/connect.h"

namespace kerf::cli {
namespace {

constexpr std::chrono::milliseconds kRedrawn{100};
constexpr std::chrono::milliseconds kPatience{500};  // A shorter wait shows no note.
constexpr double kStepNewsHz = 5.0;

void draw(const std::string& line) {
  std::fprintf(stderr, "\r%s\033[K", line.c_str());
  std::fflush(stderr);
}

// Returns "1:02:03" or "2:03".
std::string clock_time(double seconds) {
  const auto whole = static_cast<long long>(seconds + 0.5);
  char text[40];
  if (whole >= 3600) {
    std::snprintf(text, sizeof text, "%lld:%02lld:%02lld", whole / 3600, whole / 60 % 60, whole % 60);
  } else {
    std::snprintf(text, sizeof text, "%lld:%02lld", whole / 60, whole % 60);
  }
  return text;
}

}  // namespace

bool is_watched(const Session& session) {
  return !session.json && !session.quiet && isatty(STDERR_FILENO) != 0;
}

std::string progress_line(double done, double elapsed_s, const std::string& what) {
  const double share = std::clamp(done, 0.0, 1.0);
  const auto filled = static_cast<std::size_t>(share * 30.0);
  char percent[16];
  std::snprintf(percent, sizeof percent, "] %3d %%  ", static_cast<int>(100.0 * share));
  std::string line = "[" + std::string(filled, '#') + std::string(30 - filled, '.') + percent;
  if (elapsed_s >= 1.0 && share >= 0.01) line += clock_time(elapsed_s * (1.0 - share) / share) + " left  ";
  return line + what;
}

ProgressBar::~ProgressBar() {
  if (drawn_ != Clock::time_point()) draw("");
}

bool ProgressBar::is_due() {
  const Clock::time_point now = Clock::now();
  if (!live_ || now - drawn_ < kRedrawn) return false;
  drawn_ = now;
  return true;
}

void ProgressBar::show(double done, const std::string& what) {
  if (is_due()) draw(progress_line(done, std::chrono::duration<double>(drawn_ - started_).count(), what));
}

void ProgressBar::show(const std::string& what) {
  if (is_due()) draw(what);
}

WaitingNote::WaitingNote(const Session& session, std::string what) : what_(std::move(what)) {
  if (is_watched(session)) thread_ = std::thread([this] { run(); });
}

WaitingNote::~WaitingNote() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    has_ended_ = true;
  }
  ended_.notify_one();
  thread_.join();
}

void WaitingNote::run() {
  const auto started = std::chrono::steady_clock::now();
  const auto ended = [this] { return has_ended_; };
  std::unique_lock lock(mutex_);
  if (ended_.wait_for(lock, kPatience, ended)) return;
  do {
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - started;
    draw(what_ + " ... " + clock_time(elapsed.count()));
  } while (!ended_.wait_for(lock, std::chrono::seconds(1), ended));
  draw("");
}

StepProgress::StepProgress(const Session& session, const std::string& name, std::int32_t ticks) : bar_(session) {
  if (!is_watched(session)) return;
  client_ = std::make_unique<client::Client>(connect(session.server));
  v1::GetSheetRequest request;
  request.set_name(name);
  v1::Sheet sheet;
  if (!client_->call(&v1::SheetService::Stub::GetSheet, client_->sheets(), request, sheet).ok()) return;
  watcher_ = std::make_unique<client::Watcher>(*client_);
  thread_ = std::thread([this, name, first = sheet.tick(), ticks] { run(name, first, ticks); });
}

StepProgress::~StepProgress() {
  if (!thread_.joinable()) return;
  watcher_->stop();
  thread_.join();
}

void StepProgress::run(const std::string& name, std::int64_t first, std::int32_t ticks) {
  client::WatchOptions options;
  options.max_rate_hz = kStepNewsHz;
  // Ignores the end of the stream; the StepSheet call reports the result.
  static_cast<void>(watcher_->run(name, options, [&](const v1::Frame& frame, const client::Mirror& /*mirror*/) {
    const std::int64_t done = frame.tick() - first;
    bar_.show(static_cast<double>(done) / ticks, std::to_string(done) + " of " + std::to_string(ticks) + " ticks");
    return true;
  }));
}

}  // namespace kerf::cli
