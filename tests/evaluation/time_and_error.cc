// Measures CPU time of a second of motion against the error of positions, for methods of stepping and cutting. Writes
// a line of JSON for each; tests/evaluation/tradeoff calls it.
//   time_and_error SCENE [--side N] [--cuts N] [--only TEXT] [--no-times] [--export FILE]
// SCENE: swing-soft, swing-PRESET, drape, cut. PRESET: of material_presets.cc. --export also writes a swing and its
// reference.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "server/base/check.h"
#include "server/core/cut/cut.h"
#include "server/core/fem/element/material.h"
#include "server/core/mesh/build/grid_mesh.h"
#include "server/core/scene/integrator_settings.h"
#include "server/core/sheet/sheet.h"
#include "tests/bench/cpu_time.h"
#include "tests/bench/race_bullet.h"
#include "tests/bench/race_one_solve.h"
#include "tests/bench/race_scene.h"
#include "tests/evaluation/cut_cost.h"

namespace kerf::evaluation {
namespace {

using bench::Contender;
using bench::kTick;
using bench::Scene;

constexpr double kSwingTime = 0.3;     // s, before anything crumples
constexpr double kCutTime = 0.1;       // s; flaps buckle one way or the other later
constexpr double kDrapeTime = 0.25;    // s
constexpr int kCutsOfPlainSteps = 10;  // most cuts after which plain explicit steps are a reference; they get too short
constexpr int kReferenceSteps = 64;    // of TR-BDF2 a tick, after more cuts
constexpr int kPointsASide = 21;       // of a grid of points at which positions are compared
constexpr double kLongestMs = 6e4;     // CPU time after which a run is given up

struct Arguments {
  std::string scene, only, export_file;
  int side = 50, cuts = 0;
  bool has_times = true;
};

using MakeIntegrator = std::function<std::unique_ptr<fem::Integrator>()>;

struct Method {
  std::string family, setting;
  bool is_default = false;
  cut::Method cut = cut::Method::kNeighbourhood;
  std::function<std::unique_ptr<Contender>(const Scene&)> enter;
  MakeIntegrator integrator;  // for sheets of the library
};

// Steps a scene by an integrator, some times a tick.
class Stepped : public Contender {
 public:
  Stepped(const Scene& scene, const MakeIntegrator& make, int steps)
      : scene_(scene), integrator_(make()), steps_(steps) {
    integrator_->rebuild(scene_.model);
  }
  void tick() override {
    for (int i = 0; i < steps_; ++i) {
      integrator_->step(scene_.model, scene_.loads, kTick / steps_, nullptr, scene_.state);
    }
  }
  [[nodiscard]] Eigen::Matrix3Xd positions() const override { return scene_.state.x; }

 private:
  Scene scene_;
  std::unique_ptr<fem::Integrator> integrator_;
  int steps_;
};

Method stepped(const std::string& family, const std::string& setting, const MakeIntegrator& make, int steps = 1) {
  Method method;
  method.family = family;
  method.setting = setting;
  method.integrator = make;
  method.enter = [make, steps](const Scene& scene) { return std::make_unique<Stepped>(scene, make, steps); };
  return method;
}

MakeIntegrator with(const fem::IntegratorOptions& options) {
  return [options] { return fem::make_integrator(options); };
}

fem::IntegratorOptions reference_options(bool is_cut) {
  fem::IntegratorOptions options = bench::reference_options();
  options.has_local_inertia = false;
  if (is_cut) options.cfl = 0.25;  // plain steps of cut sheets are a hundred times shorter
  return options;
}

std::vector<Method> methods(bool has_bullet) {
  using enum fem::IntegratorKind;
  using Solver = linear::LinearSolverKind;
  const auto implicit = [](fem::IntegratorKind kind, int newton) {
    return with(bench::implicit_options(kind, newton, Solver::kFactorCg));
  };
  const auto one_solve = [](Solver solver) -> MakeIntegrator {
    return [solver] { return bench::make_one_solve(solver); };
  };
  std::vector<Method> all{
      stepped("Kerf as it comes", "automatic", with(scene::integrator_options(scene::IntegratorSettings(), kTick))),
      stepped("Kerf, explicit", "mixed precision", with(bench::explicit_options(fem::Precision::kMixed))),
      stepped("Kerf, explicit", "double precision", with(bench::explicit_options(fem::Precision::kDouble))),
      stepped("Kerf, TR-BDF2", "60 Hz", implicit(kTrBdf2, 5)),
      stepped("Kerf, TR-BDF2", "240 Hz", implicit(kTrBdf2, 5), 4),
      stepped("Kerf, implicit Euler", "60 Hz", implicit(kImplicitEuler, 5)),
      stepped("Kerf, implicit Euler", "240 Hz", implicit(kImplicitEuler, 5), 4),
      stepped("thesis", "plain CG, 60 Hz", one_solve(Solver::kPlainCg)),
      stepped("thesis", "direct solver, 60 Hz", one_solve(Solver::kDirect)),
      stepped("thesis", "direct solver, 240 Hz", one_solve(Solver::kDirect), 4),
  };
  all.front().is_default = true;
  for (Method& method : all) {
    if (method.family == "thesis") method.cut = cut::Method::kElement;
  }
  if (has_bullet) {
    for (const bench::Entry& entry : bench::bullet_entries()) {
      all.push_back({entry.program, entry.setting, false, cut::Method::kNeighbourhood, entry.enter, {}});
    }
  }
  return all;
}

// Material points away from vertices and edges of every grid; 0 <= i < kPointsASide^2.
Eigen::Vector2d sample_point(int i) {
  return {(i % kPointsASide + 0.53) / (kPointsASide + 0.1), (i / kPointsASide + 0.51) / (kPointsASide + 0.1)};
}

// Places of a grid of material points; points without material are at infinity.
Eigen::Matrix3Xd sampled(const mesh::TriangleMesh& mesh, const Eigen::Matrix3Xd& x) {
  Eigen::Matrix3Xd places(3, kPointsASide * kPointsASide);
  for (int i = 0; i < places.cols(); ++i) {
    const Eigen::Vector2d at = sample_point(i);
    const mesh::TriangleId t = mesh.locate(mesh.lattice().nearest(at)).triangle;
    places.col(i).setConstant(std::numeric_limits<double>::infinity());
    if (t == mesh::kNone || !mesh.is_solid(t)) continue;
    const auto& v = mesh.vertices(t);
    Eigen::Matrix2d edges;
    edges << mesh.rest_position(v[1]) - mesh.rest_position(v[0]), mesh.rest_position(v[2]) - mesh.rest_position(v[0]);
    const Eigen::Vector2d weights = edges.inverse() * (at - mesh.rest_position(v[0]));
    places.col(i) = x.col(v[0]) + weights[0] * (x.col(v[1]) - x.col(v[0])) + weights[1] * (x.col(v[2]) - x.col(v[0]));
  }
  return places;
}

struct Distances {
  double rms = 0.0, largest = 0.0;  // m
};
Distances distances(const Eigen::Matrix3Xd& found, const Eigen::Matrix3Xd& expected) {
  Distances result;
  int count = 0;
  for (Eigen::Index i = 0; i < found.cols(); ++i) {
    const bool has_material = expected.col(i).allFinite() && !found.col(i).array().isInf().any();
    if (!has_material) continue;
    const double distance = (found.col(i) - expected.col(i)).norm();  // NaN of a sheet that has burst spoils all
    ++count;
    result.rms += distance * distance;
    result.largest = std::max(result.largest, distance);
  }
  result.rms = count > 0 ? std::sqrt(result.rms / count) : std::numeric_limits<double>::quiet_NaN();
  return result;
}

bool is_asked(const Arguments& arguments, const Method& method) {
  return (method.family + " " + method.setting).find(arguments.only) != std::string::npos;
}

void print(const Arguments& arguments, const Method& method, int vertices, double ms, int ticks, int asked,
           const Distances& error) {
  nlohmann::json row{{"scene", arguments.scene}, {"side", arguments.side},    {"cuts", arguments.cuts},
                     {"family", method.family},  {"setting", method.setting}, {"default", method.is_default},
                     {"vertices", vertices}};
  if (arguments.has_times) row["cpu_s_per_s"] = 1e-3 * ms / (ticks * kTick);
  if (ticks == asked && std::isfinite(error.rms)) {
    row["rms_mm"] = 1e3 * error.rms;
    row["largest_mm"] = 1e3 * error.largest;
  }
  std::printf("%s\n", row.dump().c_str());
  std::fflush(stdout);
}

// Writes an uncut swing, the curves that cut it, and the reference, for programs that are no part of this one.
void export_swing(const Arguments& arguments, int ticks, const std::vector<cut::Curve>& curves,
                  const Eigen::Matrix3Xd& expected) {
  const Scene scene(bench::grid(arguments.side), 0.0, false);
  nlohmann::json file{{"side", arguments.side},
                      {"cuts", arguments.cuts},
                      {"tick_s", kTick},
                      {"ticks", ticks},
                      {"gravity", {scene.loads.gravity.x(), scene.loads.gravity.y(), scene.loads.gravity.z()}},
                      {"mass_kg", scene.model.mass()}};
  for (const fem::Pin& pin : scene.loads.pins) file["pins"].push_back(pin.vertex);
  file["curves"] = nlohmann::json::array();
  for (const cut::Curve& curve : curves) file["curves"].push_back(points_along(curve));
  for (int i = 0; i < expected.cols(); ++i) {
    file["points"].push_back({sample_point(i).x(), sample_point(i).y()});
    file["places"].push_back({expected(0, i), expected(1, i), expected(2, i)});
  }
  std::ofstream(arguments.export_file) << file.dump();
}

void swing(const Arguments& arguments, const fem::Material& material, bool has_bullet) {
  const double duration = arguments.cuts > 0 ? kCutTime : kSwingTime;
  const int ticks = static_cast<int>(std::lround(duration / kTick));
  const CutSheet sheet = cut_sheet(arguments.side, arguments.cuts, cut::Method::kNeighbourhood);
  const auto scene_of = [&](const mesh::TriangleMesh& mesh) {
    return Scene(mesh, 0.0, false, fem::MembraneLaw::kCorotational, material);
  };
  const Scene as_kerf = scene_of(sheet.mesh);
  const Scene as_thesis = scene_of(cut_sheet(arguments.side, arguments.cuts, cut::Method::kElement).mesh);
  Stepped reference =
      arguments.cuts > kCutsOfPlainSteps
          ? Stepped(as_kerf,
                    with(bench::implicit_options(fem::IntegratorKind::kTrBdf2, 5, linear::LinearSolverKind::kFactorCg)),
                    kReferenceSteps)
          : Stepped(as_kerf, with(reference_options(arguments.cuts > 0)), 1);
  for (int i = 0; i < ticks; ++i) reference.tick();
  const Eigen::Matrix3Xd expected = sampled(as_kerf.mesh, reference.positions());
  if (!arguments.export_file.empty()) export_swing(arguments, ticks, sheet.curves, expected);
  for (const Method& method : methods(has_bullet)) {
    if (!is_asked(arguments, method)) continue;
    const Scene& scene = method.cut == cut::Method::kElement ? as_thesis : as_kerf;
    const std::unique_ptr<Contender> contender = method.enter(scene);
    double ms = 0.0;
    int done = 0;
    while (done < ticks && ms < kLongestMs) {
      const double begin = bench::thread_cpu_s();
      contender->tick();
      ms += 1e3 * (bench::thread_cpu_s() - begin);
      ++done;
    }
    print(arguments, method, scene.mesh.num_vertices(), ms, done, ticks,
          distances(sampled(scene.mesh, contender->positions()), expected));
  }
}

// A cloth that falls on a ball with friction.
sheet::Sheet above_ball(int side, const MakeIntegrator& make) {
  scene::SheetConfig config;
  scene::GridSource grid;
  grid.columns = side;
  grid.rows = side;
  config.mesh = grid;
  config.material = bench::cloth();
  config.placement.y_axis = {0.0, 1.0, 0.0};
  config.placement.origin = {-0.5, -0.5, 0.31};
  config.colliders = {{contact::Sphere{{0.0, 0.0, 0.0}, 0.3}, 0.4}};
  Result<sheet::Sheet> sheet =
      sheet::Sheet::create(config, [&make](const fem::IntegratorOptions& /*options*/) { return make(); });
  KERF_CHECK(sheet.ok(), "the sheet of the evaluation is refused");
  return std::move(sheet).value();
}

void drape(const Arguments& arguments) {
  const int ticks = static_cast<int>(std::lround(kDrapeTime / kTick));
  const auto run = [&](const MakeIntegrator& make, double& ms, int& done) {
    sheet::Sheet sheet = above_ball(arguments.side, make);
    while (done < ticks && ms < kLongestMs) {
      const double begin = bench::thread_cpu_s();
      sheet.step({});
      ms += 1e3 * (bench::thread_cpu_s() - begin);
      ++done;
    }
    return sampled(sheet.mesh(), sheet.state().x);
  };
  double unused = -1e9;
  int reference_ticks = 0;
  const Eigen::Matrix3Xd expected = run(with(reference_options(false)), unused, reference_ticks);
  for (const Method& method : methods(false)) {
    // The thesis's solve knows of no bodies, and a sheet makes steps of 1/60 s alone.
    if (!is_asked(arguments, method) || method.family == "thesis" || method.setting == "240 Hz") continue;
    double ms = 0.0;
    int done = 0;
    const Eigen::Matrix3Xd found = run(method.integrator, ms, done);
    print(arguments, method, arguments.side * arguments.side, ms, done, ticks, distances(found, expected));
  }
}

void cuts(const Arguments& arguments) {
  const std::pair<const char*, cut::Method> methods[] = {{"Kerf", cut::Method::kNeighbourhood},
                                                         {"thesis", cut::Method::kElement}};
  for (const auto& [family, method] : methods) {
    for (nlohmann::json row : measure_cuts(arguments.side, method, arguments.has_times)) {
      row["family"] = family;
      std::printf("%s\n", row.dump().c_str());
    }
  }
}

// Finds PRESET of "swing-PRESET".
Result<fem::Material> preset_of(std::string_view scene) {
  constexpr std::string_view kSwing = "swing-";
  return fem::find_preset(scene.substr(0, kSwing.size()) == kSwing ? scene.substr(kSwing.size()) : "");
}

int run(const Arguments& arguments) {
  if (arguments.scene == "cut") {
    cuts(arguments);
  } else if (arguments.scene == "drape") {
    drape(arguments);
  } else if (arguments.scene == "swing-soft") {
    swing(arguments, bench::cloth(), arguments.cuts == 0);
  } else if (const Result<fem::Material> preset = preset_of(arguments.scene); preset.ok()) {
    swing(arguments, *preset, false);
  } else {
    std::fprintf(stderr, "no scene \"%s\"; there are: swing-soft, swing-PRESET, drape, cut\n", arguments.scene.c_str());
    return 2;
  }
  return 0;
}

}  // namespace
}  // namespace kerf::evaluation

int main(int argc, char** argv) {
  kerf::evaluation::Arguments arguments;
  if (argc > 1) arguments.scene = argv[1];
  for (int i = 2; i < argc; ++i) {
    if (std::strcmp(argv[i], "--no-times") == 0) {
      arguments.has_times = false;
      continue;
    }
    if (i + 1 == argc) break;
    const char* const name = argv[i++];
    if (std::strcmp(name, "--side") == 0) arguments.side = std::atoi(argv[i]);
    if (std::strcmp(name, "--cuts") == 0) arguments.cuts = std::atoi(argv[i]);
    if (std::strcmp(name, "--only") == 0) arguments.only = argv[i];
    if (std::strcmp(name, "--export") == 0) arguments.export_file = argv[i];
  }
  return kerf::evaluation::run(arguments);
}
