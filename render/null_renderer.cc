#include "render/null_renderer.h"

#include <utility>

namespace kerf::render {

namespace {

class NullRenderer final : public Renderer {
 public:
  NullRenderer(const std::string& reason, std::vector<DeviceOutcome> outcomes)
      : reason_(reason), outcomes_(std::move(outcomes)) {}

  Status render(const Scene& scene, const Camera& camera, int width, int height, Pixels& /*pixels*/,
                RenderTimes* /*times*/) override {
    if (Status status = validate(scene, camera, width, height); !status.ok()) return status;
    return {StatusCode::kUnavailable, "RENDERER_UNAVAILABLE", "this server cannot draw: " + reason_, ""};
  }
  [[nodiscard]] bool available() const override { return false; }
  [[nodiscard]] std::string description() const override { return "none: " + reason_; }
  [[nodiscard]] std::vector<DeviceOutcome> devices() const override { return outcomes_; }

 private:
  const std::string reason_;
  const std::vector<DeviceOutcome> outcomes_;
};

}  // namespace

std::unique_ptr<Renderer> make_null_renderer(const std::string& reason, std::vector<DeviceOutcome> outcomes) {
  return std::make_unique<NullRenderer>(reason, std::move(outcomes));
}

}  // namespace kerf::render
