#include "render/device_choice.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <system_error>

namespace kerf::render {

namespace {

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

// Returns the number that `text` is, or -1 if it is not just a number.
long index_in(const std::string& text) {
  long index = -1;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, index);
  return error == std::errc() && stop == end ? index : -1;
}

bool wanted(const RenderDevice& device, std::size_t index, const std::string& wish) {
  if (wish == kAnyDevice) return true;
  if (wish == kSoftwareDevice) return device.kind != DeviceKind::kHardware;
  if (const long number = index_in(wish); number >= 0) return static_cast<long>(index) == number;
  return lower(device.name + "\n" + device.details).find(lower(wish)) != std::string::npos;
}

// Returns the reason why the canvas does not match the wish; empty if it matches.
std::string mismatch(const RenderDevice& device, const Canvas& canvas, const std::string& wish) {
  if (wish == kAnyDevice && device.kind == DeviceKind::kHardware && canvas.draws_in_software()) {
    return "draws in software, without using it";
  }
  if (wish == kSoftwareDevice && !canvas.draws_in_software()) return "draws on hardware";
  return {};
}

}  // namespace

Status devices_to_try(std::span<const RenderDevice> offered, const std::string& wish, std::vector<std::size_t>& order) {
  order.clear();
  for (const DeviceKind kind : {DeviceKind::kHardware, DeviceKind::kSoftware, DeviceKind::kUnknown}) {
    for (std::size_t i = 0; i < offered.size(); ++i) {
      if (offered[i].kind == kind && !wish.empty() && wanted(offered[i], i, wish)) order.push_back(i);
    }
  }
  if (!order.empty() || wish == kAnyDevice) return {};
  return {StatusCode::kInvalidArgument, "UNKNOWN_DEVICE",
          "\"" + wish +
              "\" is not a device here; give auto, software, none, or the number or part of the name of one of: " +
              list_of(offered),
          "device"};
}

Status open_first(std::span<const RenderDevice> offered, std::span<const std::size_t> order, const std::string& wish,
                  const DeviceOpener& open, std::vector<DeviceOutcome>& outcomes, std::unique_ptr<Canvas>& canvas) {
  outcomes.clear();
  for (const RenderDevice& device : offered) outcomes.push_back({device, DeviceState::kNotTried, ""});
  std::string reasons;
  for (const std::size_t i : order) {
    std::unique_ptr<Canvas> opened;
    const Status status = open(i, opened);
    const std::string why = status.ok() ? mismatch(offered[i], *opened, wish) : status.message;
    if (why.empty()) {
      outcomes[i].state = DeviceState::kChosen;
      outcomes[i].words = opened->description();
      canvas = std::move(opened);
      return {};
    }
    outcomes[i].state = DeviceState::kRejected;
    outcomes[i].words = why;
    reasons += (reasons.empty() ? "" : "; ") + offered[i].name + ": " + why;
  }
  if (reasons.empty()) reasons = "EGL offers neither devices nor a surfaceless platform (apt install libegl-mesa0)";
  return {StatusCode::kUnavailable, "RENDERER_UNAVAILABLE", reasons, ""};
}

std::string list_of(std::span<const RenderDevice> devices) {
  if (devices.empty()) return "none: EGL offers nothing (apt install libegl-mesa0)";
  std::string list;
  for (std::size_t i = 0; i < devices.size(); ++i) {
    list += (i == 0 ? "" : "; ") + std::to_string(i) + ": " + devices[i].name +
            (devices[i].details.empty() ? "" : ", " + devices[i].details);
  }
  return list;
}

}  // namespace kerf::render
