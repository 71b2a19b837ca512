#include "client/cli/watch_meter.h"

#include <algorithm>
#include <cstdio>

namespace kerf::cli {
namespace {

constexpr double kRecent = 2.0;  // s
constexpr std::size_t kKeptAges = 4096;

// Returns the percentile for `share`, 0..1: the value of nearest rank between the smallest and the largest. Returns 0
// without values.
double percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto index = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), values.begin() + index, values.end());
  return values[static_cast<std::size_t>(index)];
}

// Returns "812 B", "4.2 kB" or "1.3 MB".
std::string byte_count(double bytes) {
  char text[32];
  if (bytes < 1e3) {
    std::snprintf(text, sizeof text, "%.0f B", bytes);
  } else if (bytes < 1e6) {
    std::snprintf(text, sizeof text, "%.1f kB", bytes / 1e3);
  } else {
    std::snprintf(text, sizeof text, "%.1f MB", bytes / 1e6);
  }
  return text;
}

}  // namespace

void WatchMeter::add(const Frame& frame) {
  if (frames_ == 0) first_s_ = frame.at_s;
  const auto index = static_cast<std::size_t>(frames_) % kKeptAges;
  if (index == ages_.size()) {
    ages_.push_back(frame.age_ms);
  } else {
    ages_[index] = frame.age_ms;
  }
  ++frames_;
  skipped_ += frame.skipped;
  bytes_ += frame.bytes;
  recent_.push_back(frame);
  while (recent_.front().at_s < frame.at_s - kRecent) recent_.pop_front();
}

std::string WatchMeter::status() const {
  if (recent_.empty()) return "waiting for the first frame";
  const Frame& last = recent_.back();
  // The first frame marks the start of the span, so its bytes are not counted.
  const double span = last.at_s - recent_.front().at_s;
  double bytes = 0.0;
  std::vector<double> ages;
  for (const Frame& frame : recent_) {
    if (&frame != &recent_.front()) bytes += static_cast<double>(frame.bytes);
    ages.push_back(frame.age_ms);
  }
  const double frames = static_cast<double>(recent_.size() - 1);
  char text[256];
  std::snprintf(text, sizeof text,
                "tick %lld  %.1f fps  %s/s  age p50 %.1f p95 %.1f ms  skipped %lld  %d vertices %d %s  x%.2f real time",
                static_cast<long long>(last.tick), span > 0.0 ? frames / span : 0.0,
                byte_count(span > 0.0 ? bytes / span : 0.0).c_str(), percentile(ages, 0.5), percentile(ages, 0.95),
                static_cast<long long>(skipped_), last.vertices, last.pieces, last.pieces == 1 ? "piece" : "pieces",
                last.real_time_factor);
  return text;
}

std::string WatchMeter::summary() const {
  if (frames_ == 0) return "no frames";
  const double span = recent_.back().at_s - first_s_;
  char text[256];
  std::snprintf(
      text, sizeof text,
      "%lld %s in %.1f s (%.1f fps), %s (%s a frame), %lld ticks skipped\n"
      "age of frames: p50 %.1f ms, p95 %.1f ms, worst %.1f ms",
      static_cast<long long>(frames_), frames_ == 1 ? "frame" : "frames", span,
      span > 0.0 ? static_cast<double>(frames_ - 1) / span : 0.0, byte_count(static_cast<double>(bytes_)).c_str(),
      byte_count(static_cast<double>(bytes_) / static_cast<double>(frames_)).c_str(), static_cast<long long>(skipped_),
      percentile(ages_, 0.5), percentile(ages_, 0.95), *std::max_element(ages_.begin(), ages_.end()));
  return text;
}

}  // namespace kerf::cli
