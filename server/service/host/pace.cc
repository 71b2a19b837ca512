#include "server/service/host/pace.h"

#include <algorithm>
#include <cmath>

#include "server/service/host/host.h"

namespace kerf::host {

namespace {

constexpr Nanoseconds kWindow = std::chrono::seconds(1);
constexpr double kCpuWeight = 1.0 / 16.0;  // -, weight of the newest tick in the running mean.

}  // namespace

void Pace::start(Nanoseconds now) {
  deadline_ = now;
  joined_slip_ = shared_->total();
  waited_ = Nanoseconds(0);
  last_end_ = now;
  window_begin_ = now;
  window_ticks_ = 0.0;
}

void Pace::set_speed(double speed, Nanoseconds now) {
  const Nanoseconds period(std::max(std::llround(static_cast<double>(tick_.count()) / speed), 1LL));
  const Nanoseconds due = deadline_ + period - period_;
  deadline_ = std::max(due, std::min(deadline_, now));
  period_ = period;
  speed_ = speed;
  window_begin_ = now;
  window_ticks_ = 0.0;
}

void Pace::tick_done(Nanoseconds end, Nanoseconds cpu, double share, Nanoseconds blocked) {
  waited_ += std::max(end - std::max(deadline_, last_end_) - cpu - blocked, Nanoseconds(0));
  last_end_ = end;
  deadline_ += period_;
  if (end > deadline_) ++overruns_;
  Nanoseconds given_up_time{0};
  if (end >= deadline_) {
    const std::int64_t due = (end - deadline_) / period_ + 1;  // Ticks that should have begun by now.
    if (due > Host::kMaxCatchUpTicks) {
      const std::int64_t given_up = due - Host::kMaxCatchUpTicks;
      given_up_time = given_up * period_;
      deadline_ += given_up_time;
      slipped_ += given_up * tick_;
    }
  } else {
    waited_ = Nanoseconds(0);
  }
  slipped_ += Nanoseconds(std::llround((1.0 - share) * static_cast<double>(tick_.count())));
  window_ticks_ += share;
  if (end - window_begin_ >= kWindow) {
    real_time_factor_ = window_ticks_ * seconds(tick_) / seconds(end - window_begin_);
    window_begin_ = end;
    window_ticks_ = 0.0;
  }
  add_cpu(cpu);
  share_slip(given_up_time);
}

void Pace::share_slip(Nanoseconds given_up) {
  const Nanoseconds lost = std::min(given_up, waited_);
  waited_ -= lost;
  joined_slip_ += lost;
  const bool is_light = 1.0e3 * tick_cpu_us_ <= kLightShare * static_cast<double>(period_.count());
  if (lost.count() > 0 && is_light && period_ >= kShortestShared) shared_->raise(joined_slip_);
  const Nanoseconds others = std::max(shared_->total() - joined_slip_, Nanoseconds(0));
  joined_slip_ += others;
  deadline_ += others;
  slipped_ += Nanoseconds(std::llround(static_cast<double>(others.count()) * speed_));
}

void Pace::add_cpu(Nanoseconds cpu) {
  const double us = 1.0e6 * seconds(cpu);
  tick_cpu_us_ = tick_cpu_us_ == 0.0 ? us : tick_cpu_us_ + kCpuWeight * (us - tick_cpu_us_);
}

}  // namespace kerf::host
