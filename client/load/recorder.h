#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "client/load/histogram.h"
#include "client/load/schedule.h"

namespace kerf::load {

enum class Role { kViewer, kSlow, kStalled, kImage };
inline constexpr std::array<Role, 4> kRoles{Role::kViewer, Role::kSlow, Role::kStalled, Role::kImage};
[[nodiscard]] const char* name_of(Role role);  // "viewers", "slow readers" ...

// What readers of one role saw.
struct ReaderTotals {
  std::int32_t readers = 0;                  // that got a first frame
  std::int64_t frames = 0;                   // decoded
  std::int64_t keyframes = 0;                // of these
  std::int64_t bytes = 0;                    // of these
  std::int64_t skipped = 0;                  // ticks that were not sent
  Histogram age_us;                          // from the end of the tick until the frame is decoded, frame by frame
  Histogram shown_us;                        // of what a reader shows, at times that are fixed beforehand: see ShownAge
  Histogram join_us;                         // from opening the stream to the first decoded frame; warm-up included
  std::map<std::string, std::int64_t> ends;  // how streams ended before the run did
  std::int64_t ended_without = 0;            // of these: without a first frame
};

struct CutTotals {
  std::int64_t sent = 0;
  std::int64_t applied = 0;
  std::int64_t missed = 0;  // answered NO_INTERSECTION
  std::int64_t undone = 0;  // taken back
  Histogram late_us;        // from the intended time to when it was really sent
  Histogram reply_us;       // from the intended time to the reply
  Histogram reply_ticks;    // from the newest tick that a viewer had when it was sent to the tick it was applied at
  Histogram seen_us;        // from the intended time to the first decoded frame of its tick or a later one
  std::int64_t seen_without = 0;  // of those frames: lacked the cut
  std::int64_t unseen = 0;        // of cuts on watched sheets: no such frame came before the run ended
};

// A stretch of the run, of the role kViewer.
struct Stretch {
  std::int64_t frames = 0;
  std::int64_t bytes = 0;
  Histogram age_us;
};

struct FrameSeen {
  Nanoseconds decoded{0};
  std::int64_t age_us = 0;  // 0 where the clocks disagree by more than that
  std::int64_t bytes = 0;
  std::int64_t skipped = 0;
  bool keyframe = false;
};

// Everything that is measured while a run goes on, from many threads. What happens outside begin..end is left out,
// except joins, ends and errors. Thread-safe.
class Recorder {
 public:
  static constexpr std::size_t kStretches = 120;

  // Counts nothing before measure() says from when.
  Recorder() : stretches_(kStretches) {}
  // Once: what is decoded in begin..end counts.
  void measure(Nanoseconds begin, Nanoseconds end);

  [[nodiscard]] Nanoseconds begin() const { return begin_; }
  [[nodiscard]] Nanoseconds end() const { return end_; }
  [[nodiscard]] bool counts(Nanoseconds time) const { return time >= begin() && time < end(); }

  void joined(Role role, Nanoseconds took);
  void frame(Role role, const FrameSeen& frame);
  void shown(Role role, std::int64_t age_us);
  // `joined`: the reader had a first frame.
  void ended(Role role, const std::string& how, bool joined);
  void error(const std::string& reason);
  // `change` is called with the lock held.
  template <typename Change>
  void cuts(Change change) {
    const std::lock_guard lock(mutex_);
    change(cuts_);
  }

  [[nodiscard]] ReaderTotals readers(Role role) const;
  [[nodiscard]] CutTotals cut_totals() const;
  [[nodiscard]] std::vector<Stretch> stretches() const;
  [[nodiscard]] std::map<std::string, std::int64_t> errors() const;

 private:
  ReaderTotals& of(Role role) { return readers_[static_cast<std::size_t>(role)]; }

  std::atomic<Nanoseconds> begin_{Nanoseconds::max()};
  std::atomic<Nanoseconds> end_{Nanoseconds::max()};
  mutable std::mutex mutex_;
  std::array<ReaderTotals, kRoles.size()> readers_;
  CutTotals cuts_;
  std::vector<Stretch> stretches_;
  std::map<std::string, std::int64_t> errors_;  // by reason
};

// The age of what a reader shows, at fixed times, from the frames that it decodes: between two frames the first is
// shown, and grows older. A frame that comes late counts at every one of these times, and not once.
class ShownAge {
 public:
  explicit ShownAge(Schedule times) : times_(times) {}

  // `age`: of the frame when it was decoded; `moves`: it will be followed by others, and what is shown until then grows
  // old; of a sheet that sleeps or stands it does not. Calls `sample(time, age_us)` for each of the times until
  // `decoded` at which the frame before this one was shown.
  template <typename Sample>
  void frame(Nanoseconds decoded, Nanoseconds age, bool moves, Sample sample) {
    sample_until(decoded, sample);
    decoded_ = decoded;
    age_ = age;
    moves_ = moves;
  }

  // Nobody looks any more from `end` on: the last frame was shown until then.
  template <typename Sample>
  void finish(Nanoseconds end, Sample sample) {
    sample_until(end, sample);
    moves_ = false;
  }

 private:
  template <typename Sample>
  void sample_until(Nanoseconds end, Sample& sample) {
    for (; times_.at(next_) <= end; ++next_) {
      const Nanoseconds time = times_.at(next_);
      if (moves_ && time >= decoded_) sample(time, microseconds(age_ + (time - decoded_)));
    }
  }

  Schedule times_;
  std::int64_t next_ = 0;
  Nanoseconds decoded_{0};
  Nanoseconds age_{0};
  bool moves_ = false;  // nothing is shown before the first frame
};

}  // namespace kerf::load
