#include "server/service/api/tick_advice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string_view>

namespace kerf::api {
namespace {

template <typename... Values>
std::string format(const char* pattern, Values... values) {
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(), pattern, values...);
  return text.data();
}

std::string_view name_for_people(fem::TickPart part) {
  switch (part) {
    case fem::TickPart::kMembrane:
      return "stretching";
    case fem::TickPart::kBending:
      return "bending";
    case fem::TickPart::kClusters:
      return "tiny triangles along cuts";
    case fem::TickPart::kContact:
      return "contact with bodies";
    case fem::TickPart::kLoads:
      return "wind and other loads";
    case fem::TickPart::kSolve:
      return "solving equations";
    case fem::TickPart::kSelfContact:
      return "contact of the sheet with itself";
  }
  return "";
}

std::string_view remedy(fem::TickPart part, const host::SheetStatus& status) {
  const bool is_exact = !status.softening;
  switch (part) {
    case fem::TickPart::kMembrane:
    case fem::TickPart::kBending:
      return is_exact ? "a coarser mesh, a softer material or fidelity REAL_TIME"
                      : "a coarser mesh or a softer material";
    case fem::TickPart::kClusters:
      return "undoing cuts that lie close together";
    case fem::TickPart::kContact:
      return "fewer bodies or a coarser mesh";
    case fem::TickPart::kLoads:
      return "no wind, or a coarser mesh";
    case fem::TickPart::kSolve:
      return "a coarser mesh";
    case fem::TickPart::kSelfContact:
      return "a coarser mesh, or no self-contact";
  }
  return "";
}

std::string advice(const host::SheetStatus& status) {
  const host::TickEstimate& estimate = status.tick_estimate;
  if (estimate.fits()) return {};
  const auto& ns = estimate.cost.ns;
  const auto largest = static_cast<fem::TickPart>(std::max_element(ns.begin(), ns.end()) - ns.begin());
  const double share = estimate.cost[largest] / estimate.cost.total();
  std::string text = format("A tick takes %.3g ms of the %.3g ms available: %.0f %% of it is ",
                            1e-3 * estimate.total_us(), 1e-3 * estimate.budget, 100.0 * share);
  text.append(name_for_people(largest));
  if (estimate.cost.substeps > 0.0) text += format(", in %.0f substeps", estimate.cost.substeps);
  text.append(". Remedy: ").append(remedy(largest, status));
  const double speed = std::floor(100.0 * status.stats.speed * estimate.budget / estimate.total_us()) / 100.0;
  return speed > 0.0 ? text + format("; or speed %.2g.", speed) : text + ".";
}

}  // namespace

v1::TickEstimate encode_tick_estimate(const host::SheetStatus& status) {
  const host::TickEstimate& estimate = status.tick_estimate;
  v1::TickEstimate message;
  message.set_total_us(estimate.total_us());
  message.set_budget_us(estimate.budget);
  message.set_counted_us(1e-3 * estimate.cost.total());
  message.set_substeps(estimate.cost.substeps);
  for (std::size_t i = 0; i < estimate.cost.ns.size(); ++i) {
    const double part = 1e-3 * estimate.scale * estimate.cost.ns[i];
    if (part > 0.0) (*message.mutable_parts_us())[std::string(fem::kTickPartNames[i])] = part;
  }
  message.set_advice(advice(status));
  return message;
}

std::string warning_of_slower_ticks(const host::CommandTimings& timings) {
  const bool ends_real_time = timings.tick_before_us <= timings.budget_us && timings.tick_after_us > timings.budget_us;
  if (!ends_real_time) return {};
  return format(
      "The sheet now falls behind: a tick takes %.3g ms of the %.3g ms available; before the cut it took %.3g ms.",
      1e-3 * timings.tick_after_us, 1e-3 * timings.budget_us, 1e-3 * timings.tick_before_us);
}

}  // namespace kerf::api
