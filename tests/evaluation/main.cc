// Measures what chapter 5 of the thesis measures, and writes a line of JSON for each row; tests/evaluation/run calls
// it.
//   thesis_evaluation EXPERIMENT [--repeats N] [--no-times] [--scenes FOLDER]
#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>
#include <map>
#include <string>
#include <variant>

#include <nlohmann/json.hpp>

#include "server/base/check.h"
#include "server/core/cut/cut.h"
#include "server/core/fem/element/material.h"
#include "server/core/mesh/build/grid_mesh.h"
#include "tests/accuracy/scene_file.h"
#include "tests/bench/condition_number.h"
#include "tests/evaluation/condition.h"
#include "tests/evaluation/mesh_measures.h"
#include "tests/evaluation/motion.h"
#include "tests/evaluation/pictures.h"
#include "tests/evaluation/thesis_patterns.h"

namespace kerf::evaluation {
namespace {

using nlohmann::json;

struct Arguments {
  std::string experiment;
  int repeats = 10;
  bool has_times = true;
  std::string scenes;
};

constexpr double kTick = 1.0 / 60.0;      // s
constexpr double kUncutCondition = 10.0;  // -, "within 10^1" in the thesis
constexpr int kRootsSide = 16;            // vertices a side; with its cut the sheet has 500 at most
constexpr int kTicksBefore = 30;          // ticks before the first cut
constexpr int kSolveTicks = 1;            // ticks before and after with one solve, each of which takes seconds

void print(const json& row) {
  std::printf("%s\n", row.dump().c_str());
  std::fflush(stdout);
}

json to_json(const Spread& spread) {
  return {{"mean", spread.mean}, {"deviation", spread.deviation}, {"worst", spread.worst}};
}

json to_json(const Shapes& shapes) {
  return {{"triangles", shapes.triangles},
          {"edge_ratio", to_json(shapes.edge_ratio)},
          {"aspect", to_json(shapes.aspect)},
          {"angle_deg", to_json(shapes.angle)},
          {"area_ratio", to_json(shapes.area_ratio)},
          {"slivers", shapes.share_of_slivers}};
}

json to_json(const TickTimes& times) {
  return {{"before_ms", times.before_ms},
          {"during_ms", times.during_ms},
          {"after_ms", times.after_ms},
          {"after_worst_ms", times.after_worst_ms},
          {"stages_ms", times.stages_ms},
          {"linear_residual", times.linear_residual},
          {"linear_iterations", times.linear_iterations},
          {"unconverged_ticks", times.unconverged}};
}

json to_json(const Solve& solve) {
  return {{"solver", solve.solver},
          {"ms", solve.ms},
          {"iterations", solve.iterations},
          {"residual", solve.residual},
          {"error", solve.error}};
}

// The uncut sheet, and what is compared with it.
struct Uncut {
  explicit Uncut(int grid_side)
      : side(grid_side),
        mesh(mesh::make_grid({grid_side, grid_side, 1.0, 1.0}).value()),
        wool(fem::find_preset("wool").value()),
        held{grid_side * (grid_side - 1), grid_side * grid_side - 1},
        element_area(0.5 / ((grid_side - 1) * (grid_side - 1))) {
    const ConditionMatrix matrix(mesh, wool, held);
    step10 = matrix.step_of(kUncutCondition);
    shape = bench::condition_number(mesh);
  }

  int side;
  mesh::TriangleMesh mesh;
  fem::Material wool;
  std::vector<mesh::VertexId> held;
  double element_area;
  double step10 = 0.0;  // s, with which A of the uncut sheet has the condition number 10
  double shape = 0.0;
};

json conditions(const Uncut& uncut, const mesh::TriangleMesh& mesh) {
  const ConditionMatrix matrix(mesh, uncut.wool, uncut.held);
  return {{"a", matrix.condition(kTick)},
          {"a10", matrix.condition(uncut.step10)},
          {"scaled", matrix.scaled_condition(kTick)},
          {"shape", bench::condition_number(mesh) / uncut.shape}};
}

struct CutMesh {
  mesh::TriangleMesh mesh;
  int crossed = 0, gained = 0;
};

CutMesh cut_mesh(const mesh::TriangleMesh& sheet, const std::vector<GivenCut>& cuts, const Way& way) {
  CutMesh result{sheet};
  for (const GivenCut& cut : cuts) {
    const Result<cut::CutPlan> plan = cut::plan(result.mesh, {cut.curve, options_of(cut, way), {}});
    KERF_CHECK(plan.ok(), "a cut of the evaluation is refused");
    const Result<cut::CutOutcome> outcome = cut::apply(result.mesh, *plan);
    KERF_CHECK(outcome.ok(), "a cut of the evaluation is refused");
    result.crossed += outcome->report.crossed_triangles;
    result.gained += outcome->report.new_triangles;
  }
  return result;
}

json measure_mesh(const Uncut& uncut, const CutMesh& cut, bool has_conditions) {
  json row{{"crossed", cut.crossed},
           {"gained", cut.gained},
           {"new", cut.gained + cut.crossed},
           {"vertices", cut.mesh.num_vertices()},
           {"new_shapes", to_json(measure_shapes(cut.mesh, new_triangles(uncut.mesh, cut.mesh), uncut.element_area))},
           {"all_shapes", to_json(measure_shapes(cut.mesh, all_triangles(cut.mesh), uncut.element_area))}};
  if (has_conditions) row["condition"] = conditions(uncut, cut.mesh);
  return row;
}

json measure_ticks(const scene::SheetConfig& config, const std::vector<GivenCut>& cuts, const Way& way) {
  sheet::Sheet sheet = make_sheet(config, way);
  if (way.is_one_solve) return to_json(time_ticks(sheet, kSolveTicks, commands_of(cuts, way), kSolveTicks));
  for (int i = 0; i < kTicksBefore - 10; ++i) sheet.step({});
  return to_json(time_ticks(sheet, 10, commands_of(cuts, way), 60));
}

// The sheet at the start of the step after the cut.
sheet::Sheet cut_in_motion(const scene::SheetConfig& config, const std::vector<GivenCut>& cuts, const Way& way) {
  sheet::Sheet sheet = make_sheet(config, kerf_default());
  for (int i = 0; i < kTicksBefore; ++i) sheet.step({});
  const std::vector<scene::Command> commands = commands_of(cuts, way);
  KERF_CHECK(sheet.apply(commands).replies[0].ok(), "a cut of the evaluation is refused");
  return sheet;
}

constexpr std::pair<const char*, Kind> kPatterns[] = {
    {"a", Kind::kStraight}, {"b", Kind::kCurve}, {"c", Kind::kZigzag}, {"d", Kind::kFlower}};

// Tables 5.1 and 5.2.
void four_patterns(const Arguments& arguments) {
  const Uncut uncut(50);
  print({{"experiment", "patterns"},
         {"way", "uncut"},
         {"condition", conditions(uncut, uncut.mesh)},
         {"step10_s", uncut.step10}});
  for (const auto& [name, kind] : kPatterns) {
    for (int repeat = 0; repeat < arguments.repeats; ++repeat) {
      const cut::Curve curve = random_curve(kind, uncut.mesh, {144, 166}, static_cast<std::uint32_t>(repeat));
      for (const Way& way : {no_optimisation(), thesis(), kerf_default()}) {
        json row = measure_mesh(uncut, cut_mesh(uncut.mesh, {curve}, way), true);
        row.update({{"experiment", "patterns"}, {"pattern", name}, {"way", way.name}, {"repeat", repeat}});
        if (arguments.has_times) {
          row["ticks"] = measure_ticks(wool_sheet(50), {curve}, way);
          const sheet::Sheet sheet = cut_in_motion(wool_sheet(50), {curve}, way);
          row["solve"] = to_json(time_solve(sheet, linear::LinearSolverKind::kPlainCg, {}, "cg"));
        }
        print(row);
      }
    }
  }
}

// Figures 5.2 to 5.5: bisection until new elements have ever smaller edge ratios.
void bisection_levels(const Arguments& arguments) {
  const Uncut uncut(50);
  const int runs = arguments.repeats > 2 ? 20 : 4;
  for (int run = 0; run < runs; ++run) {
    const cut::Curve curve =
        random_curve(Kind::kFlower, uncut.mesh, {94, 106}, 100U + static_cast<std::uint32_t>(run * 20 / runs));
    Way way = thesis();
    // From 12 down to 1.5.
    way.cut.element_limits.edge_ratio = 12.0 * std::pow(1.5 / 12.0, run / (runs - 1.0));
    way.cut.element_limits.area_ratio = 1e-3;
    json row = measure_mesh(uncut, cut_mesh(uncut.mesh, {curve}, way), true);
    row["before"] = measure_mesh(uncut, cut_mesh(uncut.mesh, {curve}, no_optimisation()), true);
    row.update({{"experiment", "levels"}, {"run", run + 1}, {"limit", way.cut.element_limits.edge_ratio}});
    if (arguments.has_times) {
      row["ticks"] = measure_ticks(wool_sheet(50), {curve}, way);
      row["solve"] = to_json(
          time_solve(cut_in_motion(wool_sheet(50), {curve}, way), linear::LinearSolverKind::kPlainCg, {}, "cg"));
    }
    print(row);
  }
}

// Figures 5.7 and 5.8.
void growing_cuts(const Arguments& arguments) {
  const Uncut uncut(50);
  const int sizes = arguments.repeats > 2 ? 8 : 3;
  const std::pair<const char*, std::function<std::vector<cut::Curve>(double)>> families[] = {
      {"single", single_cut}, {"intersecting", intersecting_cuts}, {"multiple", multiple_cuts}};
  for (const auto& [name, make] : families) {
    for (int i = 0; i < sizes; ++i) {
      const std::vector<cut::Curve> curves = make(i / (sizes - 1.0));
      const std::vector<GivenCut> cuts(curves.begin(), curves.end());
      for (const Way& way : {no_optimisation(), thesis(), kerf_default()}) {
        json row = measure_mesh(uncut, cut_mesh(uncut.mesh, cuts, way), false);
        row.update({{"experiment", "sizes"}, {"family", name}, {"size", i + 1}, {"way", way.name}});
        print(row);
      }
    }
  }
}

// Cuts of a scene of the gallery, at its size.
std::vector<GivenCut> cuts_of(const std::string& scene, const Arguments& arguments) {
  const Result<scene::SheetConfig> config = accuracy::read_scene_file(arguments.scenes + "/" + scene + ".json");
  KERF_CHECK(config.ok(), "a scene of the gallery is not read");
  std::vector<GivenCut> cuts;
  for (const scene::ScheduledCommand& each : config->commands) {
    if (const auto* cut = std::get_if<scene::Cut>(&each.command)) cuts.emplace_back(cut->curve, cut->options.fit);
    if (const auto* batch = std::get_if<scene::CutBatch>(&each.command)) {
      for (const scene::Cut& cut : batch->cuts) cuts.emplace_back(cut.curve, cut.options.fit);
    }
  }
  return cuts;
}

// Table 5.3, figures 5.11 and 5.12.
void detailed_cuts(const Arguments& arguments) {
  struct Group {
    const char* name;
    std::vector<const char*> scenes;
    int drawn_side;  // grid with about as many vertices as Manteaux et al. draw after the cut
  };
  const Group groups[] = {
      {"single", {"single-arc", "single-wave", "single-spiral", "single-hook", "single-lightning", "single-loop"}, 46},
      {"intersecting",
       {"crossing-x", "crossing-star", "crossing-grid", "crossing-waves", "crossing-comb", "crossing-tee"},
       70},
      {"punch", {"punch-circle", "punch-ellipse", "punch-star", "punch-heart", "punch-gear", "punch-leaf"}, 91}};
  const Uncut uncut(15);
  for (const Group& group : groups) {
    int number = 0;
    for (const char* scene : group.scenes) {
      ++number;
      const std::vector<GivenCut> cuts = cuts_of(scene, arguments);
      for (const Way& way : {thesis(), kerf_default()}) {
        json row = measure_mesh(uncut, cut_mesh(uncut.mesh, cuts, way), true);
        row.update({{"experiment", "detailed"},
                    {"group", group.name},
                    {"number", number},
                    {"scene", scene},
                    {"way", way.name}});
        if (arguments.has_times) {
          row["ticks"] = measure_ticks(wool_sheet(15), cuts, way);
          if (!way.is_one_solve && number == 1) {
            row["drawn_side"] = group.drawn_side;
            row["ticks_as_drawn"] = measure_ticks(wool_sheet(group.drawn_side), cuts, way);
          }
        }
        print(row);
      }
    }
  }
}

// Table 5.4. The roots of the matrix are dense, so they are compared on a smaller sheet.
void roots(const Arguments& arguments) {
  const Uncut large(80), small(kRootsSide);
  const int repeats = arguments.repeats > 2 ? 5 : 1;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    const cut::Curve curve =
        random_curve(Kind::kCurve, large.mesh, {154, 166}, 200U + static_cast<std::uint32_t>(repeat));
    for (const Way& way : {thesis(), kerf_default()}) {
      json row = measure_mesh(large, cut_mesh(large.mesh, {curve}, way), true);
      row.update({{"experiment", "roots"}, {"side", 80}, {"way", way.name}, {"repeat", repeat}});
      if (arguments.has_times && repeat < 2) {
        row["solve"] = to_json(
            time_solve(cut_in_motion(wool_sheet(80), {curve}, way), linear::LinearSolverKind::kPlainCg, {}, "cg"));
      }
      print(row);
    }
    const cut::Curve short_curve =
        random_curve(Kind::kCurve, small.mesh, {16, 26}, 300U + static_cast<std::uint32_t>(repeat));
    const CutMesh cut = cut_mesh(small.mesh, {short_curve}, thesis());
    json row = measure_mesh(small, cut, true);
    row.update({{"experiment", "roots"}, {"side", kRootsSide}, {"way", "thesis"}, {"repeat", repeat}});
    const sheet::Sheet sheet = cut_in_motion(wool_sheet(kRootsSide), {short_curve}, thesis());
    json solves = json::array();
    using linear::LinearSolverKind;
    solves.push_back(to_json(time_solve(sheet, LinearSolverKind::kPlainCg, {}, "cg")));
    solves.push_back(
        to_json(time_solve(sheet, LinearSolverKind::kEsCgm, {linear::EigenvalueNorm::kLog, 0.5, 5}, "es-cgm log")));
    solves.push_back(to_json(
        time_solve(sheet, LinearSolverKind::kEsCgm, {linear::EigenvalueNorm::kPower, 0.5, 5}, "es-cgm p = 1/2")));
    solves.push_back(
        to_json(time_solve(sheet, LinearSolverKind::kAsCgm, {linear::EigenvalueNorm::kPower, 0.5, 5}, "as-cgm")));
    solves.push_back(to_json(time_solve(sheet, LinearSolverKind::kDirect, {}, "direct")));
    row["solves"] = solves;
    print(row);
  }
}

// Figures 5.17 to 5.20: slits one after another.
void kirigami(const Arguments& arguments) {
  const std::vector<GivenCut> slits = cuts_of("kirigami-20", arguments);
  for (const Way& way : {thesis(), kerf_default()}) {
    mesh::TriangleMesh mesh = mesh::make_grid({50, 50, 1.0, 1.0}).value();
    sheet::Sheet sheet = make_sheet(wool_sheet(50), way);
    if (arguments.has_times && !way.is_one_solve) {
      for (int i = 0; i < kTicksBefore; ++i) sheet.step({});
    }
    int number = 0;
    for (const GivenCut& slit : slits) {
      const CutMesh cut = cut_mesh(mesh, {slit}, way);
      mesh = cut.mesh;
      json row{{"experiment", "kirigami"},
               {"way", way.name},
               {"number", ++number},
               {"crossed", cut.crossed},
               {"dimension", 3 * mesh.num_vertices()}};
      if (arguments.has_times) {
        row["ticks"] = to_json(time_ticks(sheet, 0, commands_of({slit}, way), way.is_one_solve ? 1 : 10));
      }
      print(row);
    }
  }
}

void print_all(const char* experiment, const json& rows) {
  for (json row : rows) {
    row["experiment"] = experiment;
    print(row);
  }
}

void lips(const Arguments& /*arguments*/) {
  print_all("lips", lips_in_motion());
}

void curves(const Arguments& /*arguments*/) {
  print_all("curves", growing_curves());
}

int run(const Arguments& arguments) {
  const std::map<std::string, std::function<void(const Arguments&)>> experiments{{"patterns", four_patterns},
                                                                                 {"levels", bisection_levels},
                                                                                 {"sizes", growing_cuts},
                                                                                 {"detailed", detailed_cuts},
                                                                                 {"roots", roots},
                                                                                 {"kirigami", kirigami},
                                                                                 {"lips", lips},
                                                                                 {"curves", curves}};
  const auto found = experiments.find(arguments.experiment);
  if (found == experiments.end()) {
    std::fprintf(stderr, "no experiment \"%s\"; there are:", arguments.experiment.c_str());
    for (const auto& [name, unused] : experiments) std::fprintf(stderr, " %s", name.c_str());
    std::fprintf(stderr, "\n");
    return 2;
  }
  found->second(arguments);
  return 0;
}

}  // namespace
}  // namespace kerf::evaluation

int main(int argc, char** argv) {
  kerf::evaluation::Arguments arguments;
  if (argc > 1) arguments.experiment = argv[1];
  for (int i = 2; i < argc; ++i) {
    if (std::strcmp(argv[i], "--no-times") == 0) arguments.has_times = false;
    if (std::strcmp(argv[i], "--repeats") == 0 && i + 1 < argc) arguments.repeats = std::atoi(argv[++i]);
    if (std::strcmp(argv[i], "--scenes") == 0 && i + 1 < argc) arguments.scenes = argv[++i];
  }
  return kerf::evaluation::run(arguments);
}
