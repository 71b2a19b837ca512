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

// Draws pictures of a sheet off-screen, from plain arrays to pixels. World space is right-handed, in metres; the camera
// defines the up direction. Matrices are stored by columns and multiply column vectors; front faces are
// counter-clockwise.
namespace kerf::render {

inline constexpr int kMinImageSize = 16;    // Pixels, of width and of height.
inline constexpr int kMaxImageSize = 4096;  // Pixels, of width and of height.
inline constexpr std::size_t kMaxTriangles = 2'000'000;
inline constexpr std::size_t kMaxColliders = 256;
inline constexpr std::size_t kMaxLooks = 16;
inline constexpr double kMaxCoordinate = 1e6;  // m, of every position and length.

struct Vec3 {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;

  friend bool operator==(const Vec3&, const Vec3&) = default;
};

// Represents an sRGB colour, each channel in [0, 1].
struct Colour {
  double red = 0.0;
  double green = 0.0;
  double blue = 0.0;
};

// Represents an axis-aligned box. It is empty, as initially, while lower > upper in any coordinate.
struct Bounds {
  Vec3 lower{1.0, 1.0, 1.0};     // m
  Vec3 upper{-1.0, -1.0, -1.0};  // m
};

// Views the arrays of a sheet in its present state; they must outlive the call that gets the mesh. The renderer finds
// the edges used by only one triangle: the border and the lips of cuts. It draws each as a dark line with a light strip
// beside it, inside the sheet, which is lit as a rounded edge. Hence a cut that has not opened shows as a line between
// two strips.
struct Mesh {
  std::span<const float> positions;             // 3*V, xyz interleaved, world, m, finite
  std::span<const float> material_coordinates;  // 2*V, xy interleaved, m, finite; or empty: no texture
  std::span<const std::int32_t> triangles;      // 3*T, vertex ids in [0, V), counter-clockwise from the front
  std::span<const std::int32_t> piece_ids;      // T, >= 0; pieces differ a little in colour; or empty: one piece
  std::span<const std::int32_t> looks;          // T, numbers in Style::looks; or empty: the first one everywhere
  // 3*V, sRGB, red, green, blue interleaved; or empty. They replace the colours of looks, the tints of pieces and the
  // texture. colours.h makes colours for strains and pieces.
  std::span<const std::uint8_t> vertex_colours;
  // Box of material coordinates that the texture spans, with 10 pairs of bands along its longer side. It must not
  // change while a sheet is being cut, or the texture would move over the sheet. If lower == upper, it is computed from
  // material_coordinates.
  std::array<float, 2> material_lower{0.0F, 0.0F};  // m
  std::array<float, 2> material_upper{0.0F, 0.0F};  // m, >= material_lower
};

struct Sphere {
  Vec3 centre;          // m
  double radius = 0.0;  // m, > 0
};
// Represents a half-space, solid at points p with (p - point) . normal < 0. It is drawn as ground: a disc that fades
// out, seen from above only.
struct Plane {
  Vec3 point;                  // m
  Vec3 normal{0.0, 0.0, 1.0};  // -, not zero, need not be unit.
};
struct Box {
  Vec3 centre;                                         // m
  Vec3 half_extents;                                   // m, each > 0, along the axes before rotation.
  std::array<double, 4> rotation{1.0, 0.0, 0.0, 0.0};  // Quaternion w, x, y, z; not zero, need not be unit.
};
struct Capsule {
  Vec3 start;           // m, centre of the first cap
  Vec3 end;             // m, centre of the second cap; may equal start
  double radius = 0.0;  // m, > 0
};
using Collider = std::variant<Sphere, Plane, Box, Capsule>;

inline constexpr Colour kLightBackground{0.93, 0.94, 0.96};

// Patterns in material coordinates.
enum class Pattern {
  kGingham,  // Crossing bands of dyed yarn.
  kWeave,    // Threads over and under each other.
  kTwill,    // Diagonal ribs, between which the second colour is seen.
  kGrain,    // Small irregular spots, no threads.
  kKnit,     // Rows of loops.
};

// Describes the surface of a sheet.
struct Finish {
  Pattern pattern = Pattern::kGingham;
  Colour front_dye{0.12, 0.32, 0.56};  // For kGingham: colour of the bands in front.
  Colour back_dye{0.70, 0.36, 0.20};
  Colour second{1.0, 1.0, 1.0};  // For kTwill.
  double contrast = 0.1;         // Strength of the pattern, in [0, 1].
  double grid = 0.0;             // Darkness of fine lines that show stretch and shear, in [-1, 1].
  double roughness = 0.8;        // Width of the highlight, in (0, 1].
  double sheen = 0.0;            // Light that grazes the fibres, in [0, 1].
  double translucency = 0.22;    // Share of the light on the other side that comes through, in [0, 1].
  double mirror = 0.0;           // Share of the surroundings that is mirrored, in [0, 1].
};

// Describes how a sheet, or a part of it, looks.
struct Look {
  Colour front{0.42, 0.60, 0.80};  // Colour of the side whose triangles are counter-clockwise.
  Colour back{0.95, 0.66, 0.46};   // Colour of the other side.
  Finish finish;
  Colour lips{1.00, 0.93, 0.76};  // Colour of the strips along the border and the lips of cuts.
};

// Describes the light, as what a white surface reflects of it, linear.
struct Light {
  Vec3 sky{0.42, 0.45, 0.50};     // Sky, on a surface that faces up.
  Vec3 below{0.17, 0.155, 0.15};  // On one that faces down.
  Vec3 key{0.98, 0.94, 0.86};     // Key light, on a surface that faces it.
  // Direction towards the key light, not zero; absent: over the viewer's left shoulder.
  std::optional<Vec3> towards_key;
};

struct Style {
  bool texture = true;     // Patterns in material coordinates.
  bool wireframe = false;  // Edges of triangles over the surface, fainter on small ones.
  bool borders = true;     // Lines and strips along the border and the lips of cuts.
  // Four samples per pixel, in pictures of up to 4 megapixels; about doubles a software device's time.
  bool antialias = true;
  bool shadows = true;  // Shadows of the key light, and darker ground where things hide the sky.
  Colour background = kLightBackground;
  std::optional<Colour> background_below;  // The background changes to this colour down the picture.
  Colour ground{0.76, 0.78, 0.80};
  Colour ground_lines{0.76, 0.78, 0.80};  // Lines on the ground, 0.1 m apart and, stronger, 1 m.
  Colour solids{0.75, 0.75, 0.74};
  Light light;
  std::vector<Look> looks{Look{}};  // 1 to kMaxLooks, see Mesh::looks.
};

struct Scene {
  Mesh mesh;                        // May be empty.
  std::vector<Collider> colliders;  // At most kMaxColliders.
  std::optional<Plane> ground;      // Drawn as a Plane collider is.
  Style style;
};

// Describes a camera. The near and far planes follow from the visible content.
struct Camera {
  Vec3 eye{0.0, -3.0, 1.0};    // m
  Vec3 target;                 // m, different from the eye.
  Vec3 up{0.0, 0.0, 1.0};      // -, not zero, not along target - eye (at least 0.001 rad off)
  double vertical_fov = 40.0;  // degrees, in [1, 179]

  friend bool operator==(const Camera&, const Camera&) = default;
};

// Returns the box around a sheet's vertices, unused ones included; empty for an empty mesh.
Bounds bounds_of(const Mesh& mesh);

// Returns the nearest camera that sees all `positions` (3 x V, m) with a small margin. `aspect`: width / height, > 0.
// `from`: direction from the target towards the eye; not zero, not along `up`. Without positions the camera looks at
// the origin.
Camera fit_camera(std::span<const float> positions, double aspect, Vec3 from = {0.55, -1.0, 0.55},
                  Vec3 up = {0.0, 0.0, 1.0});

// Splits the time that a call of render() takes, s; each >= 0.
struct RenderTimes {
  double prepare_s = 0.0;  // Normals, borders, views: on the caller's thread.
  double wait_s = 0.0;     // Waiting for other pictures.
  double draw_s = 0.0;     // Drawing, until the graphics device is done.
  double read_s = 0.0;     // Copying pixels to memory.
};

// These functions check arguments, as render() does before it queues a picture. They return ok, or kInvalidArgument
// with the field:
//   camera: "CAMERA_NOT_FINITE", "CAMERA_SINGULAR" (eye == target; up zero or parallel), "FOV_OUT_OF_RANGE";
//   size: "SIZE_OUT_OF_RANGE";
//   scene: "ARRAY_SIZE_MISMATCH", "NOT_FINITE", "INDEX_OUT_OF_RANGE", "LIMIT_EXCEEDED", "SHAPE_DEGENERATE",
//          "COLOUR_OUT_OF_RANGE".
Status validate(const Camera& camera);
Status validate_size(int width, int height);
Status validate(const Scene& scene);
// Checks size, camera, scene, in that order.
Status validate(const Scene& scene, const Camera& camera, int width, int height);

enum class DeviceKind {
  kHardware,
  kSoftware,  // Draws on the processor.
  kUnknown,   // The driver chooses the device.
};

// Represents an EGL device or platform that can give a graphics context without a window system.
struct RenderDevice {
  std::string name;     // E.g. "EGL device 0"; unique.
  std::string details;  // For people, e.g. "/dev/dri/renderD128" or "software"; may be empty.
  DeviceKind kind = DeviceKind::kUnknown;
};

enum class DeviceState {
  kChosen,
  kUsable,    // Gives a context too, but another is chosen; probe_devices() only.
  kRejected,  // Gives no context, or one of another kind than wished.
  kNotTried,  // Not wished, or another device was chosen before.
};

struct DeviceOutcome {
  RenderDevice device;
  DeviceState state = DeviceState::kNotTried;
  std::string words;  // Chosen or usable: GL vendor, renderer and version; rejected: the reason.
};

// Draws scenes. Callable from any thread. Calls block until their picture is done; they share one render thread, the
// sole owner of the graphics context.
class Renderer {
 public:
  virtual ~Renderer() = default;

  // Draws a width x height picture into `pixels`, alpha 255 throughout; on failure leaves it unchanged. The same scene,
  // camera and size give the same bytes on the same machine and driver. Errors, besides those of validate():
  //   kResourceExhausted  "RENDER_QUEUE_FULL"      too many calls are waiting
  //   kUnavailable        "RENDERER_UNAVAILABLE"   there is none; see description()
  //                       "CONTEXT_LOST"           the next call makes a new context
  //                       "SHUTTING_DOWN"
  //   kInternal           "DRAWING_FAILED"         the driver failed, with its words
  // `times`: null, or overwritten on success. To measure them, the call waits for the device between drawing and
  // reading, which takes a little longer.
  virtual Status render(const Scene& scene, const Camera& camera, int width, int height, Pixels& pixels,
                        RenderTimes* times = nullptr) = 0;

  // False for the null renderer, which cannot draw.
  [[nodiscard]] virtual bool available() const = 0;

  // Returns one line: device, GL vendor, renderer and version, and the devices rejected before it with reasons. For the
  // null renderer it is "none: <reason>".
  [[nodiscard]] virtual std::string description() const = 0;

  // Returns the outcome of each device of this machine when the renderer was made; empty if none was tried.
  [[nodiscard]] virtual std::vector<DeviceOutcome> devices() const { return {}; }
};

inline constexpr const char* kAnyDevice = "auto";
inline constexpr const char* kSoftwareDevice = "software";
inline constexpr const char* kNoDevice = "none";

struct RendererOptions {
  int max_waiting = 16;  // Calls that may wait behind the one being drawn, >= 0; more are refused.
  // "auto": hardware if available, else software; "software"; "none"; the number of one of devices(); or a part of a
  // device's name or details, ignoring case.
  std::string device = kAnyDevice;
};

// Checks that make_renderer() will find a device to try. Errors: kInvalidArgument "UNKNOWN_DEVICE", with the list of
// devices in the message.
Status check_device(const std::string& device);

// Makes the EGL renderer on the first matching device that gives an OpenGL 3.3 core context: hardware, then Mesa's
// software device, then Mesa's surfaceless platform. If none does, or the build has no EGL, it returns the null
// renderer, which refuses every picture with the reason. Never null.
std::unique_ptr<Renderer> make_renderer(const RendererOptions& options = {});

// Opens every device of this machine in turn on the calling thread; kChosen marks the one for "auto".
std::vector<DeviceOutcome> probe_devices();

}  // namespace kerf::render
