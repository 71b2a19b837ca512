// The audit is worth what it catches: each fault of faults.toml must be caught in a fixed list of cuts. It is caught by
// the audit, a cut that is refused without need, a crash, or running out of processor time. Without a fault nothing is
// found.
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "fault_names.h"
#include "server/base/random.h"
#include "tests/audit/audited_cut.h"
#include "tests/cut/hard_cases.h"
#include "tests/faults/fault_switch.h"
#include "tests/property/random_curves.h"
#include "tests/property/random_sheets.h"

namespace kerf::faults {
namespace {

using audit::AuditedCut;
using audit::Finding;

constexpr rlim_t kSecondsOfATrial = 8;              // of processor time; all cuts without a fault take about one
constexpr rlim_t kBytesOfATrial = rlim_t{2} << 30;  // of address space
constexpr int kSheets = 60;
constexpr int kCutsOfASheet = 10;
constexpr audit::Depth kDepth{false, true, false, 60};

// Cuts with the fault switched on, on a sheet that was made with it off.
AuditedCut cut(int fault, mesh::TriangleMesh& mesh, const cut::CutRequest& request) {
  switched_on = fault;
  AuditedCut done = audit::cut_and_audit(mesh, request, kDepth);
  if (!done.flaw && done.end == AuditedCut::End::kRefused) done.flaw = "refused: " + done.reason;
  switched_on = 0;
  return done;
}

cut::Curve on_unit_square(cut::Curve curve) {
  return property::mapped(
      std::move(curve), [](const Eigen::Vector2d& p) { return Eigen::Vector2d(p / cut::kCells); }, 1.0 / cut::kCells);
}

Finding run_hard_cases(int fault) {
  const mesh::TriangleMesh sheet = test::grid(cut::kCells + 1);
  for (const cut::HardCase& item : cut::hard_cases()) {
    mesh::TriangleMesh mesh = sheet;
    for (const cut::Curve& curve : item.curves) {
      const AuditedCut done = cut(fault, mesh, {on_unit_square(curve), {}, {}});
      if (done.flaw) return item.name + (": " + *done.flaw);
    }
  }
  // A strip that runs out over a small piece apart, which its sides do not touch.
  mesh::TriangleMesh parts = test::must(mesh::import_mesh(test::indexed(
      {{0, 0}, {4, 0}, {4, 4}, {0, 4}, {5, 1.9}, {5.2, 2}, {5, 2.1}}, {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}})));
  cut::CutRequest strip{cut::Polyline{{{3, 2}, {6, 2}}}, {}, {}};
  strip.options.width_m = 1.0;
  if (Finding flaw = cut(fault, parts, strip).flaw) return "strip over a piece: " + *flaw;
  mesh::TriangleMesh mesh = sheet;
  const cut::Curve dusty = cut::cells({{3.3, 5.4}, {6.3, 5.6}, {6.3001, 5.6}, {8.6, 6.3}});
  if (cut(fault, mesh, {on_unit_square(dusty), {}, {}}).outcome.report.merged_segments == 0) return "dust not reported";
  return std::nullopt;
}

// Sequences of random cuts on random sheets, with holes, components and regions, with vertices that must stay.
Finding run_random_cuts(int fault) {
  for (std::uint64_t seed = 1; seed <= kSheets; ++seed) {
    SeededRandom random(seed);
    const property::RandomArrays made = property::random_arrays(random);
    mesh::TriangleMesh mesh = test::must(mesh::import_mesh(made.arrays));
    std::vector<cut::Curve> earlier;
    for (int i = 0; i < kCutsOfASheet && mesh.num_triangle_slots() < 4000; ++i) {
      cut::CutRequest request{property::random_curve(random, mesh, made.frame, earlier), {}, {}};
      if (random.below(3) == 0) request.options.relax = false;
      if (random.below(3) == 0) request.options.min_angle_deg = 0.0;
      if (random.below(4) == 0) request.options.width_m = made.frame.scale * std::pow(10.0, random.uniform(-4.0, -0.5));
      for (mesh::VertexId v = mesh.num_vertices() - 1; v >= 0; v -= 3) request.fixed_vertices.push_back(v);
      earlier.push_back(request.curve);
      const AuditedCut done = cut(fault, mesh, request);
      if (done.flaw) return "sheet " + std::to_string(seed) + ", cut " + std::to_string(i) + ": " + *done.flaw;
    }
  }
  return std::nullopt;
}

// 0 where nothing is found. What is found goes to `pipe`; nothing does where memory ran out.
int run_in_child(int fault, int pipe) {
  try {
    Finding found = run_hard_cases(fault);
    if (!found) found = run_random_cuts(fault);
    if (!found) return 0;
    return write(pipe, found->data(), found->size()) < 0 ? 2 : 1;
  } catch (const std::exception&) {
    return 3;
  }
}

// Runs all cuts in a process of its own. What caught the fault, or nothing.
Finding caught_by(int fault) {
  std::array<int, 2> ends{};
  EXPECT_EQ(pipe(ends.data()), 0);
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    const rlimit limit{kSecondsOfATrial, kSecondsOfATrial};
    setrlimit(RLIMIT_CPU, &limit);
    const rlimit memory{kBytesOfATrial, kBytesOfATrial};
    setrlimit(RLIMIT_AS, &memory);
    const rlimit no_core{0, 0};
    setrlimit(RLIMIT_CORE, &no_core);
    if (std::freopen("/dev/null", "w", stderr) == nullptr) _exit(2);
    _exit(run_in_child(fault, ends[1]));
  }
  close(ends[1]);
  std::string text;
  std::array<char, 256> buffer{};
  for (ssize_t got = 0; (got = read(ends[0], buffer.data(), buffer.size())) > 0;) {
    text.append(buffer.data(), static_cast<std::size_t>(got));
  }
  close(ends[0]);
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return std::nullopt;
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    return signal == SIGXCPU || signal == SIGKILL ? "ran out of time" : "crashed";
  }
  return text.empty() ? "crashed" : text;
}

TEST(NoFault, NothingIsFoundWhereThereIsNone) {
  EXPECT_EQ(run_hard_cases(0).value_or(""), "");
  EXPECT_EQ(run_random_cuts(0).value_or(""), "");
}

class Faults : public testing::TestWithParam<int> {};  // their numbers, from 1

TEST_P(Faults, IsCaught) {
  const char* name = kFaultNames[static_cast<std::size_t>(GetParam() - 1)];
  const Finding found = caught_by(GetParam());
  EXPECT_TRUE(found.has_value()) << "fault " << GetParam() << " survived: " << name;
  std::printf("%2d %s\n   %s\n", GetParam(), name, found.value_or("SURVIVED").c_str());
}

static_assert(kFaultNames.size() >= 40);
INSTANTIATE_TEST_SUITE_P(Each, Faults, testing::Range(1, static_cast<int>(kFaultNames.size()) + 1));

}  // namespace
}  // namespace kerf::faults
