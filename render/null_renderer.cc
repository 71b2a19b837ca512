#include "render/null_renderer.h"

namespace kerf::render {

namespace {

class NullRenderer final : public Renderer {
 public:
  explicit NullRenderer(const std::string& reason) : reason_(reason) {}

  Status render(const Scene& scene, const Camera& camera, int width, int height, Pixels& /*pixels*/,
                RenderTimes* /*times*/) override {
    if (Status status = validate(scene, camera, width, height); !status.ok()) return status;
    return {StatusCode::kUnavailable, "RENDERER_UNAVAILABLE", "this server cannot draw: " + reason_, ""};
  }
  [[nodiscard]] bool available() const override { return false; }
  [[nodiscard]] std::string description() const override { return "none: " + reason_; }

 private:
  const std::string reason_;
};

}  // namespace

std::unique_ptr<Renderer> make_null_renderer(const std::string& reason) {
  return std::make_unique<NullRenderer>(reason);
}

}  // namespace kerf::render
