#include "server/service/offline/files.h"

#include <array>
#include <filesystem>
#include <utility>
#include <variant>

#include "server/core/cut/fit.h"
#include "server/service/drawing/inflate.h"
#include "server/service/dxf/dxf.h"
#include "server/service/svg/path_data.h"
#include "server/service/svg/svg.h"
#include "server/service/wire/drawing_codec.h"
#include "server/service/wire/geometry_codec.h"
#include "server/service/wire/integrator_codec.h"
#include "server/service/wire/mesh_source_codec.h"
#include "server/service/wire/scene_codec.h"

namespace kerf::offline {
namespace {

constexpr std::size_t kLargeDxf = std::size_t{512} << 10;  // Bytes of a DXF file that is sent as it is, at most.

template <typename Choice>
struct NamedChoice {
  std::string_view name;
  Choice choice;
};

constexpr std::array<NamedChoice<scene::IntegratorKind>, 6> kIntegrators{{
    {"explicit", scene::IntegratorKind::kExplicitLeapfrog},
    {"implicit", scene::IntegratorKind::kImplicitEuler},
    {"trapezoidal", scene::IntegratorKind::kTrapezoidal},
    {"bdf2", scene::IntegratorKind::kBdf2},
    {"tr-bdf2", scene::IntegratorKind::kTrBdf2},
    {"auto", scene::IntegratorKind::kAutomatic},
}};
constexpr std::array<NamedChoice<scene::Precision>, 2> kPrecisions{{
    {"double", scene::Precision::kDouble},
    {"mixed", scene::Precision::kMixed},
}};
constexpr std::array<NamedChoice<scene::Fidelity>, 2> kFidelities{{
    {"exact", scene::Fidelity::kExact},
    {"real-time", scene::Fidelity::kRealTime},
}};
constexpr std::array<NamedChoice<fem::MembraneLaw>, 2> kMembraneLaws{{
    {"corotational", fem::MembraneLaw::kCorotational},
    {"green", fem::MembraneLaw::kGreen},
}};

Error unknown_choice(const std::string& field, const std::string& name) {
  return invalid_argument("UNKNOWN_CHOICE", "\"" + name + "\" is not a known " + field, field);
}

template <typename Choice, std::size_t n>
Status choose(const std::array<NamedChoice<Choice>, n>& choices, const std::string& field, const std::string& name,
              Choice& chosen) {
  if (name.empty()) return Nothing{};
  for (const NamedChoice<Choice>& one : choices) {
    if (one.name != name) continue;
    chosen = one.choice;
    return Nothing{};
  }
  return unknown_choice(field, name);
}

Status choose_solver(const std::string& name, scene::LinearSolverKind& chosen) {
  if (name.empty()) return Nothing{};
  for (const linear::LinearSolverName& one : linear::kLinearSolverNames) {
    if (one.option != name) continue;
    chosen = one.kind;
    return Nothing{};
  }
  return unknown_choice("solver", name);
}

Status apply(const Overrides& overrides, scene::IntegratorSettings& settings) {
  KERF_TRY(choose(kIntegrators, "integrator", overrides.integrator, settings.kind));
  KERF_TRY(choose(kPrecisions, "precision", overrides.precision, settings.precision));
  return choose_solver(overrides.solver, settings.solver);
}

}  // namespace

Result<scene::SheetConfig> read_scene(Disk& disk, const std::string& path) {
  KERF_TRY_ASSIGN(const std::string json, disk.read_file(path, wire::kMaxSceneFileBytes));
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  return wire::decode_scene_file(json, [&disk, &folder](const std::string& file) {
    return disk.read_file((folder / file).string(), scene::kMaxMeshFileBytes);
  });
}

v1::Scene to_message(const scene::SheetConfig& config) {
  return wire::encode_scene(config);
}

Status apply(const Overrides& overrides, scene::SheetConfig& config) {
  scene::IntegratorSettings integrator = config.integrator;
  scene::Fidelity fidelity = config.fidelity;
  fem::MembraneLaw membrane_law = config.membrane_law;
  KERF_TRY(apply(overrides, integrator));
  KERF_TRY(choose(kFidelities, "fidelity", overrides.fidelity, fidelity));
  KERF_TRY(choose(kMembraneLaws, "membrane_law", overrides.membrane_law, membrane_law));
  config.integrator = integrator;
  config.fidelity = fidelity;
  config.membrane_law = membrane_law;
  return Nothing{};
}

Result<v1::Integrator> integrator_message(const Overrides& overrides) {
  scene::IntegratorSettings settings;
  KERF_TRY(apply(overrides, settings));
  return wire::encode_integrator(settings);
}

std::vector<std::string> integrator_names() {
  std::vector<std::string> names;
  for (const auto& integrator : kIntegrators) names.emplace_back(integrator.name);
  return names;
}

std::vector<std::string> solver_names() {
  std::vector<std::string> names;
  for (const linear::LinearSolverName& solver : linear::kLinearSolverNames) names.emplace_back(solver.option);
  return names;
}

Result<v1::ObjMesh> read_obj(Disk& disk, const std::string& path) {
  KERF_TRY_ASSIGN(std::string content, disk.read_file(path, scene::kMaxMeshFileBytes));
  KERF_TRY_ASSIGN(content, wire::unpacked_mesh(std::move(content), "OBJ", "obj"));
  v1::ObjMesh mesh;
  mesh.set_text(wire::obj_text(std::move(content)));
  return mesh;
}

Result<v1::PlyMesh> read_ply(Disk& disk, const std::string& path) {
  KERF_TRY_ASSIGN(std::string content, disk.read_file(path, scene::kMaxMeshFileBytes));
  KERF_TRY_ASSIGN(content, wire::unpacked_mesh(std::move(content), "PLY", "ply"));
  v1::PlyMesh mesh;
  mesh.set_data(std::move(content));
  return mesh;
}

Result<v1::Curve> read_drawing(Disk& disk, const std::string& path, const v1::DrawingReading& reading) {
  KERF_TRY_ASSIGN(std::string content, disk.read_file(path, svg::kMaxFileBytes));
  v1::Curve curve;
  if (dxf::is_dxf(content)) {
    // Compressed, the largest file fits into a request.
    const bool is_packed = content.size() > kLargeDxf && !drawing::is_gzip(content);
    curve.mutable_dxf()->set_data(is_packed ? drawing::gzipped(content) : std::move(content));
    if (reading.ByteSizeLong() > 0) *curve.mutable_dxf()->mutable_reading() = reading;
    return curve;
  }
  KERF_TRY_ASSIGN(*curve.mutable_svg()->mutable_text(), svg::outline_text(content));
  if (reading.ByteSizeLong() > 0) *curve.mutable_svg()->mutable_reading() = reading;
  return curve;
}

Result<v1::DrawingReport> inspect_drawing(Disk& disk, const std::string& path, const v1::DrawingReading& reading) {
  KERF_TRY_ASSIGN(v1::Curve curve, read_drawing(disk, path, reading));
  v1::InspectDrawingRequest request;
  if (curve.has_dxf()) {
    *request.mutable_dxf() = std::move(*curve.mutable_dxf());
  } else {
    *request.mutable_svg() = std::move(*curve.mutable_svg());
  }
  return wire::inspect_drawing(request);
}

Result<DrawingSize> size_of_drawing(const v1::Curve& curve) {
  KERF_TRY_ASSIGN(wire::DecodedCurve decoded, wire::decode_curve(curve, "cut.curve", {}));
  DrawingSize size;
  size.is_placed = decoded.is_placed;
  const cut::Box fitted = cut::frame(decoded.curve);
  size.fitted_width = fitted.high.x() - fitted.low.x();
  size.fitted_height = fitted.high.y() - fitted.low.y();
  if (auto* path = std::get_if<cut::Path>(&decoded.curve);
      path != nullptr && (curve.svg().reading().fit_page() || curve.dxf().reading().fit_page())) {
    path->subpaths.erase(path->subpaths.begin(), path->subpaths.begin() + 2);  // The corners of the page.
  }
  const cut::Box box = cut::extent(decoded.curve);
  size.width = box.high.x() - box.low.x();
  size.height = box.high.y() - box.low.y();
  return size;
}

Result<v1::Path> parse_path(std::string_view data) {
  svg::PathData parsed = svg::parse_path_data(data, cut::kMaxPathSegments);
  if (!parsed.error.empty()) return invalid_argument("SVG_PATH", parsed.error);
  v1::Curve curve;
  wire::encode_curve(cut::Path{std::move(parsed.subpaths)}, curve);
  return std::move(*curve.mutable_path());
}

}  // namespace kerf::offline
