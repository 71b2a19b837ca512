#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "render/draw_list.h"

namespace kerf::render {

// Holds a graphics context and the objects made in it. Created, used and destroyed on one thread.
class Canvas {
 public:
  virtual ~Canvas() = default;

  // Draws `list` into `pixels`; sets draw_s and read_s of `times` unless `times` is null. After a failure the canvas is
  // unusable and must be destroyed.
  virtual Status draw(const DrawList& list, Pixels& pixels, RenderTimes* times) = 0;

  // Returns one line: vendor, renderer, version.
  [[nodiscard]] virtual std::string description() const = 0;

  // True if OpenGL draws on the processor, even if the device is listed as hardware.
  [[nodiscard]] virtual bool draws_in_software() const = 0;
};

// Makes a canvas on the calling thread; on failure `canvas` stays null. `outcomes` is overwritten with the outcome of
// each device.
using CanvasFactory = std::function<Status(std::unique_ptr<Canvas>& canvas, std::vector<DeviceOutcome>& outcomes)>;

}  // namespace kerf::render
