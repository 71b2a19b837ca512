#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "render/draw_list.h"

namespace kerf::render {

// A graphics context and what was made in it. Created, used and destroyed on one thread.
class Canvas {
 public:
  virtual ~Canvas() = default;

  // Overwrites `pixels`, and draw_s and read_s of `times` where that is not null. After a failure the canvas is in no
  // known state and must be thrown away.
  virtual Status draw(const DrawList& list, Pixels& pixels, RenderTimes* times) = 0;

  // One line: vendor, renderer, version.
  [[nodiscard]] virtual std::string description() const = 0;

  // On the processor, whatever the device is called.
  [[nodiscard]] virtual bool draws_in_software() const = 0;
};

// Makes a canvas on the calling thread; on failure `canvas` stays null. `outcomes` is overwritten with what became of
// each device on the way.
using CanvasFactory = std::function<Status(std::unique_ptr<Canvas>& canvas, std::vector<DeviceOutcome>& outcomes)>;

}  // namespace kerf::render
