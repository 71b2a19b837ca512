#include "render/gl_canvas.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <optional>

#include "render/colours.h"
#include "render/gl_objects.h"

namespace kerf::render {

namespace {

constexpr int kSamples = 4;                        // Antialiasing samples per pixel, 8 bytes each.
constexpr std::int64_t kMaxSampled = 2048 * 2048;  // Pixels; a larger picture gets one sample per pixel.
constexpr int kShadowMapSize = 1024;               // Texels.
// Solids and ground are drawn farther from the eye by this share of their distance, so that a sheet resting on them
// hides them.
constexpr double kSupportsBehind = 0.0015;
constexpr double kBordersInFront = 3.0;  // Sides of a pixel by which border lines are drawn nearer than their edges.
constexpr double kLipsInFront = 2.0;     // As kBordersInFront, for the strips of lips.
constexpr double kLipWidth = 2.0;        // Pixels, in pictures of up to 480 rows; proportional to the rows above that.
constexpr double kMaxLipWidth = 0.006;   // Largest lip width, as a share of the diagonal of the box around the sheet.
constexpr double kPenumbra = 3.0;        // Radius of a shadow's soft edge, in texels of the shadow map.
constexpr double kGroundPenumbra = 5.0;  // As kPenumbra, on the ground: objects that shade it are farther away.

// Holds the OpenGL objects of a context; they can be made only once the context exists.
struct Objects {
  Program sheet;
  Program solid;
  Program ground;
  Program lip;
  Program line;
  Program shadow;
  Program backdrop;
  VertexStream sheet_vertices;
  VertexStream solid_vertices;
  VertexStream ground_vertices;
  VertexStream border_segments;
  ShadowMap shadow_map{kShadowMapSize};
  RenderTarget target;    // Drawn into.
  RenderTarget resolved;  // Copy of `target` with one sample per pixel, from which pixels are read.
};

double supports_z_offset(const DrawList& list) {
  return list.views.depth_per_fraction * (1.0 / (1.0 + kSupportsBehind) - 1.0);
}

// Returns one value of each look.
template <typename Of>
auto of_each(const std::vector<Look>& looks, const Of& of) {
  std::vector<decltype(of(looks[0]))> values;
  for (const Look& look : looks) values.push_back(of(look));
  return values;
}

void set_looks(const Program& program, const std::vector<Look>& looks) {
  const auto set = [&](const char* name, const auto& of) { program.set(name, of_each(looks, of)); };
  set("u_front", [](const Look& look) { return linear(look.front); });
  set("u_back", [](const Look& look) { return linear(look.back); });
  set("u_front_dye", [](const Look& look) { return linear(look.finish.front_dye); });
  set("u_back_dye", [](const Look& look) { return linear(look.finish.back_dye); });
  set("u_second", [](const Look& look) { return linear(look.finish.second); });
  set("u_pattern", [](const Look& look) { return static_cast<float>(look.finish.pattern); });
  set("u_contrast", [](const Look& look) { return static_cast<float>(look.finish.contrast); });
  set("u_grid", [](const Look& look) { return static_cast<float>(look.finish.grid); });
  set("u_roughness", [](const Look& look) { return static_cast<float>(look.finish.roughness); });
  set("u_sheen", [](const Look& look) { return static_cast<float>(look.finish.sheen); });
  set("u_translucency", [](const Look& look) { return static_cast<float>(look.finish.translucency); });
  set("u_mirror", [](const Look& look) { return static_cast<float>(look.finish.mirror); });
}

class GlCanvas final : public Canvas {
 public:
  Status open(const EglPlatform& platform);
  Status draw(const DrawList& list, Pixels& pixels, RenderTimes* times) override;
  [[nodiscard]] std::string description() const override { return description_; }
  [[nodiscard]] bool draws_in_software() const override;

 private:
  Status check_context() const;
  Status build_programs();
  Status resize(int width, int height, bool antialias);
  void upload(const DrawList& list) const;
  void draw_shadow_map(const DrawList& list) const;
  void set_surface_uniforms(const Program& program, const DrawList& list) const;
  void draw_backdrop(const Colour& above, const Colour& below) const;
  void draw_ground(const DrawList& list) const;
  void draw_solids(const DrawList& list) const;
  void draw_sheet(const DrawList& list) const;
  void draw_borders(const DrawList& list) const;
  void draw_lips(const DrawList& list, double z_offset) const;
  void draw_border_lines(const DrawList& list, double z_offset) const;
  void read_back(Pixels& pixels) const;

  EglContext context_;                                      // Declared before objects_, so destroyed after them.
  PFNGLGETGRAPHICSRESETSTATUSPROC reset_status_ = nullptr;  // Null if the driver does not report resets.
  std::string renderer_;                                    // OpenGL's name of the renderer.
  std::string description_;
  std::optional<Objects> objects_;
  int width_ = 0;    // Pixels, of the targets.
  int height_ = 0;   // pixels
  int samples_ = 0;  // Per pixel of the target; 0: no antialiasing.
};

bool has_extension(const std::string& name) {
  GLint count = 0;
  glGetIntegerv(GL_NUM_EXTENSIONS, &count);
  for (GLint i = 0; i < count; ++i) {
    if (name == reinterpret_cast<const char*>(glGetStringi(GL_EXTENSIONS, static_cast<GLuint>(i)))) return true;
  }
  return false;
}

Status GlCanvas::open(const EglPlatform& platform) {
  if (Status status = context_.open(platform); !status.ok()) return status;
  const auto text = [](GLenum name) { return std::string(reinterpret_cast<const char*>(glGetString(name))); };
  renderer_ = text(GL_RENDERER);
  description_ = text(GL_VENDOR) + ", " + renderer_ + ", OpenGL " + text(GL_VERSION);
  if (context_.tells_resets() && has_extension("GL_ARB_robustness")) {
    reset_status_ =
        reinterpret_cast<PFNGLGETGRAPHICSRESETSTATUSPROC>(EglContext::function("glGetGraphicsResetStatusARB"));
  }
  objects_.emplace();
  return build_programs();
}

bool GlCanvas::draws_in_software() const {
  const auto names = {"llvmpipe", "softpipe", "swrast", "SwiftShader", "Software Rasterizer"};
  return std::ranges::any_of(names, [this](const char* name) { return renderer_.find(name) != std::string::npos; });
}

Status GlCanvas::check_context() const {
  if (Status status = context_.check(); !status.ok() || reset_status_ == nullptr) return status;
  const GLenum reset = reset_status_();
  if (reset == GL_NO_ERROR) return {};
  return {StatusCode::kUnavailable, "CONTEXT_LOST",
          "the graphics context was lost (reset status " + std::to_string(reset) + "); try again", ""};
}

Status GlCanvas::build_programs() {
  Objects& o = *objects_;
  const auto surface = {kSurfaceVertexShader};
  if (Status s = o.sheet.build("sheet", surface, {kLightingShader, kSheetFragmentShader}); !s.ok()) return s;
  if (Status s = o.solid.build("solid", surface, {kLightingShader, kSolidFragmentShader}); !s.ok()) return s;
  if (Status s = o.ground.build("ground", surface, {kLightingShader, kGroundFragmentShader}); !s.ok()) return s;
  if (Status s = o.lip.build("lip", {kLipVertexShader}, {kLightingShader, kLipFragmentShader}); !s.ok()) return s;
  if (Status s = o.line.build("line", {kLineVertexShader}, {kLineFragmentShader}); !s.ok()) return s;
  if (Status s = o.shadow.build("shadow", {kShadowVertexShader}, {kShadowFragmentShader}); !s.ok()) return s;
  if (Status s = o.backdrop.build("backdrop", {kBackdropVertexShader}, {kBackdropFragmentShader}); !s.ok()) return s;
  for (const VertexStream* stream : {&o.sheet_vertices, &o.solid_vertices, &o.ground_vertices}) {
    stream->set_layout({{3, GL_FLOAT, offsetof(SurfaceVertex, position)},
                        {3, GL_FLOAT, offsetof(SurfaceVertex, normal)},
                        {2, GL_FLOAT, offsetof(SurfaceVertex, material)},
                        {4, GL_UNSIGNED_BYTE, offsetof(SurfaceVertex, tint)},
                        {1, GL_FLOAT, offsetof(SurfaceVertex, look)}},
                       sizeof(SurfaceVertex), 0);
  }
  o.border_segments.set_layout({{3, GL_FLOAT, offsetof(BorderSegment, start)},
                                {3, GL_FLOAT, offsetof(BorderSegment, end)},
                                {3, GL_FLOAT, offsetof(BorderSegment, start_inward)},
                                {3, GL_FLOAT, offsetof(BorderSegment, end_inward)},
                                {3, GL_FLOAT, offsetof(BorderSegment, start_normal)},
                                {3, GL_FLOAT, offsetof(BorderSegment, end_normal)},
                                {1, GL_FLOAT, offsetof(BorderSegment, look)}},
                               sizeof(BorderSegment), 1);
  return {};
}

Status GlCanvas::resize(int width, int height, bool antialias) {
  const int samples = antialias && static_cast<std::int64_t>(width) * height <= kMaxSampled ? kSamples : 0;
  if (width == width_ && height == height_ && samples == samples_) return {};
  if (Status status = objects_->target.resize(width, height, samples, true); !status.ok()) return status;
  if (Status status = objects_->resolved.resize(width, height, 0, false); !status.ok()) return status;
  width_ = width;
  height_ = height;
  samples_ = samples;
  return {};
}

Status GlCanvas::draw(const DrawList& list, Pixels& pixels, RenderTimes* times) {
  const auto begun = std::chrono::steady_clock::now();
  if (Status status = check_context(); !status.ok()) return status;
  if (Status status = resize(list.width, list.height, list.style.antialias); !status.ok()) return status;
  upload(list);
  glEnable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  if (list.style.shadows) draw_shadow_map(list);

  glBindFramebuffer(GL_FRAMEBUFFER, objects_->target.framebuffer());
  glViewport(0, 0, width_, height_);
  const Colour& background = list.style.background;
  glClearColor(static_cast<float>(background.red), static_cast<float>(background.green),
               static_cast<float>(background.blue), 1.0F);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  if (list.style.background_below) draw_backdrop(background, *list.style.background_below);
  glBindTexture(GL_TEXTURE_2D, objects_->shadow_map.texture());
  // Keeps the picture opaque: alpha is never blended.
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);
  draw_ground(list);
  draw_solids(list);
  draw_sheet(list);
  draw_borders(list);
  if (times != nullptr) glFinish();
  const auto drawn = std::chrono::steady_clock::now();
  read_back(pixels);
  if (times != nullptr) {
    times->draw_s = std::chrono::duration<double>(drawn - begun).count();
    times->read_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - drawn).count();
  }

  if (Status status = check_context(); !status.ok()) return status;
  if (const GLenum error = glGetError(); error != GL_NO_ERROR) {
    return drawing_failed("OpenGL error " + std::to_string(error));
  }
  return {};
}

void GlCanvas::upload(const DrawList& list) const {
  objects_->sheet_vertices.upload(list.sheet);
  objects_->solid_vertices.upload(list.solids);
  objects_->ground_vertices.upload(list.ground);
  objects_->border_segments.upload(list.borders);
}

void GlCanvas::draw_shadow_map(const DrawList& list) const {
  const Objects& o = *objects_;
  glBindFramebuffer(GL_FRAMEBUFFER, o.shadow_map.framebuffer());
  glViewport(0, 0, o.shadow_map.size(), o.shadow_map.size());
  glClear(GL_DEPTH_BUFFER_BIT);
  o.shadow.use();
  o.shadow.set("u_shadow_from_world", list.views.shadow_from_world);
  o.sheet_vertices.draw(list.sheet.size());
  o.solid_vertices.draw(list.solids.size());
}

void GlCanvas::set_surface_uniforms(const Program& program, const DrawList& list) const {
  program.use();
  program.set("u_clip_from_world", list.views.clip_from_world);
  program.set("u_clip_z_offset", 0.0);
  program.set("u_eye", list.eye);
  program.set("u_up", list.up);
  program.set("u_to_light", list.views.to_light);
  program.set("u_light_sky", list.style.light.sky);
  program.set("u_light_below", list.style.light.below);
  program.set("u_light_key", list.style.light.key);
  program.set("u_shadows", list.style.shadows);
  program.set("u_shadow_from_world", list.views.shadow_from_world);
  program.set("u_shadow_texel_m", list.views.shadow_extent / kShadowMapSize);
  program.set("u_shadow_texel", 1.0 / kShadowMapSize);
  program.set("u_penumbra_texels", kPenumbra);
}

void GlCanvas::draw_backdrop(const Colour& above, const Colour& below) const {
  const Program& program = objects_->backdrop;
  program.use();
  program.set("u_above", Vec3{above.red, above.green, above.blue});
  program.set("u_below", Vec3{below.red, below.green, below.blue});
  glDisable(GL_DEPTH_TEST);
  objects_->ground_vertices.bind();  // Any array will do: the shader reads none.
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glEnable(GL_DEPTH_TEST);
}

void GlCanvas::draw_ground(const DrawList& list) const {
  if (list.ground.empty()) return;
  set_surface_uniforms(objects_->ground, list);
  objects_->ground.set("u_clip_z_offset", supports_z_offset(list));
  objects_->ground.set("u_penumbra_texels", kGroundPenumbra);
  objects_->ground.set("u_ground", linear(list.style.ground));
  objects_->ground.set("u_ground_lines", linear(list.style.ground_lines));
  glEnable(GL_BLEND);
  objects_->ground_vertices.draw(list.ground.size());
  glDisable(GL_BLEND);
}

void GlCanvas::draw_solids(const DrawList& list) const {
  if (list.solids.empty()) return;
  set_surface_uniforms(objects_->solid, list);
  objects_->solid.set("u_clip_z_offset", supports_z_offset(list));
  objects_->solid.set("u_solids", linear(list.style.solids));
  objects_->solid_vertices.draw(list.solids.size());
}

void GlCanvas::draw_sheet(const DrawList& list) const {
  if (list.sheet.empty()) return;
  const Program& program = objects_->sheet;
  set_surface_uniforms(program, list);
  set_looks(program, list.style.looks);
  program.set("u_textured", list.textured);
  program.set("u_coloured", list.coloured);
  program.set("u_wireframe", list.style.wireframe);
  program.set("u_wire_width_px", std::max(1.0, height_ / 800.0));
  objects_->sheet_vertices.draw(list.sheet.size());
}

void GlCanvas::draw_borders(const DrawList& list) const {
  if (list.borders.empty()) return;
  const auto nearer_by = [&list](double pixel_sides) {
    const double fraction = std::min(pixel_sides * list.views.pixel_fraction, 0.05);
    return list.views.depth_per_fraction * (1.0 / (1.0 - fraction) - 1.0);
  };
  glDepthMask(GL_FALSE);  // Strips of neighbouring lips overlap and must not hide each other.
  objects_->border_segments.bind();
  draw_lips(list, nearer_by(kLipsInFront));
  draw_border_lines(list, nearer_by(kBordersInFront));
  glDepthMask(GL_TRUE);
}

void GlCanvas::draw_lips(const DrawList& list, double z_offset) const {
  const Program& program = objects_->lip;
  set_surface_uniforms(program, list);
  program.set("u_clip_z_offset", z_offset);
  program.set("u_lip", of_each(list.style.looks, [](const Look& look) { return linear(look.lips); }));
  program.set("u_width_fraction", kLipWidth * std::max(1.0, height_ / 480.0) * list.views.pixel_fraction);
  program.set("u_max_width_m", kMaxLipWidth * list.sheet_size);
  glDrawArraysInstanced(GL_TRIANGLES, 0, 6, static_cast<GLsizei>(list.borders.size()));
}

void GlCanvas::draw_border_lines(const DrawList& list, double z_offset) const {
  const Program& program = objects_->line;
  program.use();
  program.set("u_clip_from_world", list.views.clip_from_world);
  program.set("u_clip_z_offset", z_offset);
  program.set("u_half_viewport_px", 0.5 * width_, 0.5 * height_);
  program.set("u_half_width_px", std::max(0.6, height_ / 800.0));
  glEnable(GL_BLEND);
  glDrawArraysInstanced(GL_TRIANGLES, 0, 6, static_cast<GLsizei>(list.borders.size()));
  glDisable(GL_BLEND);
}

void GlCanvas::read_back(Pixels& pixels) const {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, objects_->target.framebuffer());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, objects_->resolved.framebuffer());
  glBlitFramebuffer(0, 0, width_, height_, 0, 0, width_, height_, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, objects_->resolved.framebuffer());
  pixels.width = width_;
  pixels.height = height_;
  const std::size_t row = 4 * static_cast<std::size_t>(width_);
  const auto num_rows = static_cast<std::size_t>(height_);
  pixels.rgba.resize(row * num_rows);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width_, height_, GL_RGBA, GL_UNSIGNED_BYTE, pixels.rgba.data());
  for (std::size_t top = 0; top < num_rows / 2; ++top) {  // OpenGL's first row is the lowest.
    const auto upper = pixels.rgba.begin() + static_cast<std::ptrdiff_t>(row * top);
    const auto lower = pixels.rgba.begin() + static_cast<std::ptrdiff_t>(row * (num_rows - 1 - top));
    std::swap_ranges(upper, upper + static_cast<std::ptrdiff_t>(row), lower);
  }
}

}  // namespace

Status make_gl_canvas(const EglPlatform& platform, std::unique_ptr<Canvas>& canvas) {
  auto made = std::make_unique<GlCanvas>();
  Status status = made->open(platform);
  if (status.ok()) canvas = std::move(made);
  return status;
}

}  // namespace kerf::render
