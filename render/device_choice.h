#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "render/canvas.h"
#include "render/renderer.h"

// Which graphics device draws. Knows nothing of EGL, so that it can be tested with devices that are not there.
namespace kerf::render {

// What to try, best first: indices into `offered`. `wish` is RendererOptions::device:
//   "auto"       hardware in the order offered, then software, then ways whose device is not known
//   "software"   software, then ways whose device is not known
//   a number     the device at that index
//   other words  the devices whose name or details hold them, whatever the case of letters; hardware first
// Errors: kInvalidArgument "UNKNOWN_DEVICE", with the list of devices in the message.
Status devices_to_try(std::span<const RenderDevice> offered, const std::string& wish, std::vector<std::size_t>& order);

// Makes a canvas on a device, given by its index; on failure `canvas` stays null.
using DeviceOpener = std::function<Status(std::size_t device, std::unique_ptr<Canvas>& canvas)>;

// Opens the first device of `order` that gives a canvas such as was wished. A device told to be hardware whose canvas
// draws in software is none under "auto" (the software devices follow anyway), and one that draws on hardware is none
// under "software". `outcomes` is overwritten: one for each device offered, in the order offered.
// Errors: kUnavailable "RENDERER_UNAVAILABLE" with what each device said.
Status open_first(std::span<const RenderDevice> offered, std::span<const std::size_t> order, const std::string& wish,
                  const DeviceOpener& open, std::vector<DeviceOutcome>& outcomes, std::unique_ptr<Canvas>& canvas);

// The devices, numbered from 0, on one line.
std::string list_of(std::span<const RenderDevice> devices);

}  // namespace kerf::render
