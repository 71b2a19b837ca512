#include "server/service/host/admission.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

namespace kerf::host {

namespace {

// -, weight of the newest tick in the running mean; one slow tick counts little.
constexpr double kNewestWeight = 1.0 / 16.0;

}  // namespace

WorkerNeed::WorkerNeed(Nanoseconds period, Nanoseconds expected_tick)
    : period_ns_(static_cast<double>(period.count())),
      share_(std::min(static_cast<double>(expected_tick.count()) / period_ns_, 1.0)) {}

Nanoseconds WorkerNeed::guessed_tick(std::int64_t num_vertices) {
  return Nanoseconds(300 * num_vertices);
}

void WorkerNeed::tick_done(Nanoseconds wall) {
  const double share = std::min(static_cast<double>(wall.count()) / period_ns_, 1.0);
  share_ += kNewestWeight * (share - share_);
}

void WorkerNeed::set_period(Nanoseconds period) {
  const auto period_ns = static_cast<double>(period.count());
  share_ = std::min(share_ * period_ns_ / period_ns, 1.0);
  period_ns_ = period_ns;
}

std::int64_t WorkerNeed::value() const {
  return std::llround(share_ * static_cast<double>(kWhole));
}

Status Admission::admit(double load, std::int32_t workers) {
  if (max_load_ == 0.0) return Nothing{};
  const double reopens_below = kReopenShare * max_load_;
  closed_ = load >= (closed_ ? reopens_below : max_load_);
  if (!closed_) return Nothing{};
  std::ostringstream message;
  message << std::fixed << std::setprecision(2) << "running sheets need " << load * workers << " of " << workers
          << " workers; from " << max_load_ * workers << " on, new ones are refused until the need is below "
          << reopens_below * workers
          << ": pause or delete sheets, give them fewer vertices or a lower tick_rate_hz, or create this one paused";
  return resource_exhausted("OVERLOADED", message.str());
}

}  // namespace kerf::host
