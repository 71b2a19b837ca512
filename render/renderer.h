#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "render/image.h"

// Pictures of a sheet, drawn off-screen. Plain arrays in, pixels out. World space is right-handed, in metres; which way
// is up is the camera's to say. Matrices and vectors are columns; front faces are counter-clockwise.
namespace kerf::render {

inline constexpr int kMinImageSize = 16;    // pixels, of width and of height
inline constexpr int kMaxImageSize = 4096;  // pixels, of width and of height
inline constexpr std::size_t kMaxTriangles = 2'000'000;
inline constexpr std::size_t kMaxColliders = 256;
inline constexpr double kMaxCoordinate = 1e6;  // m, of every position and length

struct Vec3 {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;

  friend bool operator==(const Vec3&, const Vec3&) = default;
};

// sRGB, each in [0, 1].
struct Colour {
  double red = 0.0;
  double green = 0.0;
  double blue = 0.0;
};

// An axis-aligned box. Empty while lower > upper in any coordinate, as it is to begin with.
struct Bounds {
  Vec3 lower{1.0, 1.0, 1.0};     // m
  Vec3 upper{-1.0, -1.0, -1.0};  // m
};

// A sheet as it is now: a view, so the arrays must outlive the call. Edges that only one triangle uses (the border and
// the lips of cuts) are found; each is drawn as a dark line and, inside the sheet along it, a light strip that is lit
// as a rounded edge, so that a cut that has not opened shows as a line between two strips.
struct Mesh {
  std::span<const float> positions;             // 3*V, xyz interleaved, world, m, finite
  std::span<const float> material_coordinates;  // 2*V, xy interleaved, m, finite; or empty: no texture
  std::span<const std::int32_t> triangles;      // 3*T, vertex ids in [0, V), counter-clockwise from the front
  std::span<const std::int32_t> piece_ids;      // T, >= 0: pieces differ a little in colour; or empty: one piece
  // 3*V, sRGB, red, green, blue interleaved: in place of the style's front and back, of pieces and of checks; or empty.
  // colours.h has those of strains and of pieces.
  std::span<const std::uint8_t> vertex_colours;
  // The box that the texture is scaled to: 20 checks along its longer side. It must not change while a sheet is being
  // cut, or the texture swims; taken from material_coordinates where lower == upper.
  std::array<float, 2> material_lower{0.0F, 0.0F};  // m
  std::array<float, 2> material_upper{0.0F, 0.0F};  // m, >= material_lower
};

struct Sphere {
  Vec3 centre;          // m
  double radius = 0.0;  // m, > 0
};
// Solid where (p - point) . normal < 0. Drawn as ground: a disc that fades out, seen from above only.
struct Plane {
  Vec3 point;                  // m
  Vec3 normal{0.0, 0.0, 1.0};  // -, not zero, need not be unit
};
struct Box {
  Vec3 centre;                                         // m
  Vec3 half_extents;                                   // m, each > 0, along the axes before rotation
  std::array<double, 4> rotation{1.0, 0.0, 0.0, 0.0};  // quaternion w, x, y, z; not zero, need not be unit
};
struct Capsule {
  Vec3 start;           // m, centre of the first cap
  Vec3 end;             // m; may equal start
  double radius = 0.0;  // m, > 0
};
using Collider = std::variant<Sphere, Plane, Box, Capsule>;

inline constexpr Colour kLightBackground{0.93, 0.94, 0.96};
inline constexpr Colour kDarkBackground{0.11, 0.13, 0.16};

struct Style {
  bool texture = true;  // crossing bands of dyed yarn and threads, in material coordinates
  bool wireframe =
      false;            // the edges of every triangle over the surface, fainter the smaller triangles are; no threads
  bool borders = true;  // lines and strips along the border and the lips of cuts
  bool antialias =
      true;  // four samples a pixel, in pictures of up to 4 megapixels; about doubles a software device's time
  bool shadows = true;  // of the key light, and what hides the sky from the ground
  Colour background = kLightBackground;
  Colour front{0.20, 0.43, 0.66};  // of the side whose triangles are counter-clockwise
  Colour back{0.90, 0.50, 0.26};   // of the other
  Colour lips{1.00, 0.93, 0.76};   // of the strips along the border and the lips of cuts
};

struct Scene {
  Mesh mesh;                        // may be empty
  std::vector<Collider> colliders;  // at most kMaxColliders
  std::optional<Plane> ground;      // to stand things on; drawn as a Plane collider is
  Style style;
};

// Near and far planes follow from what there is to see. The key light comes over the viewer's left shoulder.
struct Camera {
  Vec3 eye{0.0, -3.0, 1.0};    // m
  Vec3 target;                 // m, not the eye
  Vec3 up{0.0, 0.0, 1.0};      // -, not zero, not along target - eye (at least 0.001 rad off)
  double vertical_fov = 40.0;  // degrees, in [1, 179]

  friend bool operator==(const Camera&, const Camera&) = default;
};

// The box around a sheet's vertices; empty for an empty mesh. Vertices that no triangle uses count.
Bounds bounds_of(const Mesh& mesh);

// The camera nearest to `positions` (3 x V, m) that sees all of them in an image of the given aspect ratio (width /
// height, > 0) with a small margin, from the direction `from` (from the target towards the eye; not zero, not along
// up). Without positions it looks at the origin.
Camera fit_camera(std::span<const float> positions, double aspect, Vec3 from = {0.55, -1.0, 0.55},
                  Vec3 up = {0.0, 0.0, 1.0});

// Where the time of a picture went, s; each >= 0.
struct RenderTimes {
  double prepare_s = 0.0;  // normals, borders, views: on the caller's thread
  double wait_s = 0.0;     // for pictures of others
  double draw_s = 0.0;     // the graphics device, until it is done
  double read_s = 0.0;     // pixels back to memory
};

// What render() checks before anything is queued; kInvalidArgument with the field, or ok.
//   camera: "CAMERA_NOT_FINITE", "CAMERA_SINGULAR" (eye == target; up zero or parallel), "FOV_OUT_OF_RANGE";
//   size: "SIZE_OUT_OF_RANGE";
//   scene: "ARRAY_SIZE_MISMATCH", "NOT_FINITE", "INDEX_OUT_OF_RANGE", "LIMIT_EXCEEDED", "SHAPE_DEGENERATE",
//          "COLOUR_OUT_OF_RANGE".
Status validate(const Camera& camera);
Status validate_size(int width, int height);
Status validate(const Scene& scene);
Status validate(const Scene& scene, const Camera& camera, int width, int height);  // size, camera, scene, in that order

enum class DeviceKind {
  kHardware,
  kSoftware,  // draws on the processor
  kUnknown,   // a way to whichever device the driver takes
};

// A way to a graphics context that needs no window system.
struct RenderDevice {
  std::string name;     // e.g. "EGL device 0"; no two have the same
  std::string details;  // for people, e.g. "/dev/dri/renderD128" or "software"; may be empty
  DeviceKind kind = DeviceKind::kUnknown;
};

enum class DeviceState {
  kChosen,
  kUsable,    // gives a context as well; probe_devices() only
  kRejected,  // gives none, or not of the kind wished
  kNotTried,  // not wished, or another was found first
};

struct DeviceOutcome {
  RenderDevice device;
  DeviceState state = DeviceState::kNotTried;
  std::string words;  // chosen or usable: GL vendor, renderer and version; rejected: why
};

// Draws scenes. Safe to call from any thread; calls block until their picture is done and share one render thread,
// which alone owns the graphics context.
class Renderer {
 public:
  virtual ~Renderer() = default;

  // Overwrites `pixels` with a width x height picture, alpha 255 throughout; on failure leaves it as it was. The same
  // scene, camera and size give the same bytes on the same machine and driver. Errors, beside those of validate():
  //   kResourceExhausted  "RENDER_QUEUE_FULL"      too many calls are waiting
  //   kUnavailable        "RENDERER_UNAVAILABLE"   there is none; see description()
  //                       "CONTEXT_LOST"           the next call starts on a fresh context
  //                       "SHUTTING_DOWN"
  //   kInternal           "DRAWING_FAILED"         the driver refused, with its words
  // `times`: null, or overwritten on success; waiting for the device between drawing and reading takes a little time.
  virtual Status render(const Scene& scene, const Camera& camera, int width, int height, Pixels& pixels,
                        RenderTimes* times = nullptr) = 0;

  // False for the null renderer.
  [[nodiscard]] virtual bool available() const = 0;

  // One line: device, GL vendor, renderer and version, and which devices were rejected before it and why; "none:
  // <reason>" for the null renderer.
  [[nodiscard]] virtual std::string description() const = 0;

  // What became of each device that this machine offers when the renderer was made; empty where nobody looked.
  [[nodiscard]] virtual std::vector<DeviceOutcome> devices() const { return {}; }
};

inline constexpr const char* kAnyDevice = "auto";
inline constexpr const char* kSoftwareDevice = "software";
inline constexpr const char* kNoDevice = "none";

struct RendererOptions {
  int max_waiting = 16;  // calls that may wait behind the one being drawn, >= 0; more are refused
  // "auto": hardware if there is any, else software; "software"; "none"; the number of one of devices(); or a part of a
  // device's name or details, whatever the case of letters.
  std::string device = kAnyDevice;
};

// Whether make_renderer() will find something to try. Errors: kInvalidArgument "UNKNOWN_DEVICE", with the list of
// devices in the message.
Status check_device(const std::string& device);

// The EGL renderer, on the first of the devices wished that gives an OpenGL 3.3 core context: hardware, then Mesa's
// software device, then Mesa's surfaceless platform. Where none does, or the build has no EGL, the null renderer, which
// refuses every picture and says why. Never null.
std::unique_ptr<Renderer> make_renderer(const RendererOptions& options = {});

// Opens every device that this machine offers, one after the other, on the calling thread; kChosen is the one that
// "auto" takes.
std::vector<DeviceOutcome> probe_devices();

}  // namespace kerf::render
