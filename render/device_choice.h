#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "render/canvas.h"
#include "render/renderer.h"

// Chooses the graphics device. Independent of EGL, so it can be tested with devices that do not exist.
namespace kerf::render {

// Fills `order` with the devices to try, best first, as indices into `offered`. `wish` is RendererOptions::device:
//   "auto"       hardware in the order offered, then software, then platforms whose device is not known
//   "software"   software, then platforms whose device is not known
//   a number     the device at that index
//   other words  the devices whose name or details contain them, ignoring case; hardware first
// Errors: kInvalidArgument "UNKNOWN_DEVICE", with the list of devices in the message.
Status devices_to_try(std::span<const RenderDevice> offered, const std::string& wish, std::vector<std::size_t>& order);

// Makes a canvas on a device, given by its index among those offered; on failure `canvas` stays null.
using DeviceOpener = std::function<Status(std::size_t device, std::unique_ptr<Canvas>& canvas)>;

// Opens the first device of `order` whose canvas matches the wish. Under "auto" it rejects a hardware device whose
// canvas draws in software, because devices known as software come later in `order`. Under "software" it rejects a
// canvas that draws on hardware. `outcomes` is overwritten: one for each device offered, in the order offered. Errors:
// kUnavailable "RENDERER_UNAVAILABLE" with the reason why each device was rejected.
Status open_first(std::span<const RenderDevice> offered, std::span<const std::size_t> order, const std::string& wish,
                  const DeviceOpener& open, std::vector<DeviceOutcome>& outcomes, std::unique_ptr<Canvas>& canvas);

// Returns the devices on one line, numbered from 0.
std::string list_of(std::span<const RenderDevice> devices);

}  // namespace kerf::render
