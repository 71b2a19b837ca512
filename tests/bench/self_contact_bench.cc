// Scenes in which sheets touch themselves: how much passes through itself, and what a tick of 1/60 s costs.
//   self_contact_bench [LETTERS [SECONDS [INTEGRATOR]]] [--without] [--obj FOLDER]
// LETTERS: scenes of tests/support/self_contact_scenes.h, such as abd; all without. SECONDS: of motion; 0, or none,
// for each scene's own. INTEGRATOR: explicit (the default), automatic, euler, trapezoidal, bdf2 or tr-bdf2. --obj: the
// last shape of each scene is written to FOLDER as a.obj and so on.
// Pairs are those of triangles that pass through each other, at the end of each tick. The step of layers is the least
// distance between the mean heights of a layer and of the one below. Times are CPU times of Sheet::step.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iomanip>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/core/contact/intersections.h"
#include "server/core/fem/element/state.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/sheet/sheet.h"
#include "tests/bench/cpu_time.h"
#include "tests/bench/scenes.h"
#include "tests/bench/self_contact_bullet.h"
#include "tests/support/self_contact_scenes.h"
#include "tests/support/solid_triangles.h"

namespace kerf::bench {
namespace {

using scenes::SelfContactScene;

const std::map<std::string_view, scene::IntegratorKind>& integrators() {
  static const std::map<std::string_view, scene::IntegratorKind> all{
      {"explicit", scene::IntegratorKind::kExplicitLeapfrog},
      {"automatic", scene::IntegratorKind::kAutomatic},
      {"euler", scene::IntegratorKind::kImplicitEuler},
      {"trapezoidal", scene::IntegratorKind::kTrapezoidal},
      {"bdf2", scene::IntegratorKind::kBdf2},
      {"tr-bdf2", scene::IntegratorKind::kTrBdf2}};
  return all;
}

// Pairs that the prototype of self-contact counted with its contact switched off.
struct PrototypeCount {
  double seconds;  // after that much motion
  int pairs;
};
const std::map<char, PrototypeCount>& prototype_counts() {
  static const std::map<char, PrototypeCount> all{
      {'a', {1.0, 7872}}, {'b', {1.5, 602}}, {'d', {5.0, 2887}}, {'e', {20.0, 32}}};
  return all;
}

struct Options {
  std::string letters;
  double seconds = 0.0;  // 0: each scene's own
  scene::IntegratorKind integrator = scene::IntegratorKind::kExplicitLeapfrog;
  std::optional<std::string> folder;
  bool has_contact = true;
};

int ticks_of(double seconds) {
  return static_cast<int>(std::lround(seconds / kTick));
}

// Keeps counts of pairs and times of ticks.
struct Record {
  std::vector<std::int64_t> pairs;
  std::vector<double> ms;

  [[nodiscard]] std::size_t most() const {
    return static_cast<std::size_t>(std::max_element(pairs.begin(), pairs.end()) - pairs.begin());
  }
  [[nodiscard]] double mean_ms() const {
    double sum = 0.0;
    for (const double of_tick : ms) sum += of_tick;
    return sum / static_cast<double>(ms.size());
  }
  [[nodiscard]] double worst_ms() const { return *std::max_element(ms.begin(), ms.end()); }
  template <typename Step>
  void time(const Step& step) {
    const double before = thread_cpu_s();
    step();
    ms.push_back(1e3 * (thread_cpu_s() - before));
  }
};

std::int64_t count_pairs(const sheet::Sheet& sheet) {
  return contact::IntersectionSearch().count(test::solid_triangles(sheet.mesh()), sheet.state().x);
}

// m
double least_step(const sheet::Sheet& sheet) {
  std::vector<scene::Piece> pieces = sheet.pieces();
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 1; k < pieces.size(); ++k) {
    least = std::min(least, pieces[k].world_centroid.z() - pieces[k - 1].world_centroid.z());
  }
  return least;
}

// As `kerf sheet create --obj` reads it: texture coordinates are material coordinates.
void write_obj(const sheet::Sheet& sheet, const std::string& path) {
  std::ofstream file(path);
  file << std::setprecision(9);
  for (mesh::VertexId v = 0; v < sheet.mesh().num_vertices(); ++v) {
    const Eigen::Vector3d at = sheet.state().x.col(v);
    const Eigen::Vector2d material = sheet.mesh().rest_position(v);
    file << "v " << at.x() << ' ' << at.y() << ' ' << at.z() << '\n';
    file << "vt " << material.x() << ' ' << material.y() << '\n';
  }
  for (const auto& corners : test::solid_triangles(sheet.mesh())) {
    file << 'f';
    for (const mesh::VertexId v : corners) file << ' ' << v + 1 << '/' << v + 1;
    file << '\n';
  }
}

sheet::Sheet make(const SelfContactScene& scene, const Options& options) {
  scene::SheetConfig config = scene.make();
  config.integrator.kind = options.integrator;
  config.self_contact.is_on = options.has_contact;
  return create(std::move(config));
}

void add(const fem::SelfContactStats& of, fem::SelfContactStats& to) {
  to.phases += of.phases;
  to.searches += of.searches;
  to.late += of.late;
  to.pairs += of.pairs;
  to.contacts += of.contacts;
  to.repairs += of.repairs;
  to.zones += of.zones;
  to.unsettled += of.unsettled;
}

void measure(const SelfContactScene& scene, const Options& options) {
  sheet::Sheet sheet = make(scene, options);
  const int ticks = ticks_of(options.seconds > 0.0 ? options.seconds : scene.seconds);
  Record record;
  double energy = sheet.energies().total();
  double gain = -std::numeric_limits<double>::infinity();
  std::uint32_t flags = 0;
  fem::SelfContactStats self;
  for (int i = 0; i < ticks; ++i) {
    fem::StepStats stats;
    record.time([&] { stats = sheet.step({}).stats; });
    flags |= stats.flags;
    add(stats.self_contact, self);
    const double before = std::exchange(energy, sheet.energies().total());
    gain = std::max(gain, energy - before);
    record.pairs.push_back(count_pairs(sheet));
  }
  std::string beside = "-";
  if (const auto found = prototype_counts().find(scene.letter); found != prototype_counts().end()) {
    const auto at = static_cast<std::size_t>(ticks_of(found->second.seconds));
    beside = (at <= record.pairs.size() ? std::to_string(record.pairs[at - 1]) : "-") + ", " +
             std::to_string(found->second.pairs);
  }
  std::string step = "-";
  if (scene.has_layers) step = std::to_string(1e3 * least_step(sheet));
  std::printf("| %c, %s | %d | %d | %ld | %ld, %zu | %s | %s | %.2f, %.2f | %.1e | %x | %016lx |\n", scene.letter,
              scene.name, sheet.mesh().num_vertices(), ticks, record.pairs.back(), record.pairs[record.most()],
              record.most() + 1, beside.c_str(), step.c_str(), record.mean_ms(), record.worst_ms(), gain, flags,
              sheet.state_hash());
  const auto of_ticks = [ticks](std::int64_t sum) { return static_cast<double>(sum) / ticks; };
  std::printf(
      "a tick: %.1f phases, %.1f searches (%ld late in all), %.0f pairs, %.0f contacts, %.1f repairs, %.1f zones; "
      "%ld unsettled\n",
      of_ticks(self.phases), of_ticks(self.searches), self.late, of_ticks(self.pairs), of_ticks(self.contacts),
      of_ticks(self.repairs), of_ticks(self.zones), self.unsettled);
  std::fflush(stdout);
  if (options.folder) write_obj(sheet, *options.folder + "/" + scene.letter + ".obj");
}

void print(const std::string& setting, int ticks, const Record& record) {
  std::printf("| %s | %d | %ld | %ld, %zu | %.2f, %.2f |\n", setting.c_str(), ticks, record.pairs.back(),
              record.pairs[record.most()], record.most() + 1, record.mean_ms(), record.worst_ms());
  std::fflush(stdout);
}

// Kerf and Bullet for 2 s, unless SECONDS are given.
void race(const SelfContactScene& scene, const Options& options) {
  const std::vector<SelfContactEntry> entries = bullet_self_contact_entries();
  const int ticks = ticks_of(options.seconds > 0.0 ? options.seconds : 2.0);
  std::printf("\nScene %c beside Bullet:%s\n", scene.letter,
              entries.empty() ? " built without it (Debian: libbullet-dev)" : "");
  std::printf("| program | ticks | pairs at the end | most, in tick | ms a tick, worst |\n|---|---|---|---|---|\n");
  sheet::Sheet sheet = make(scene, options);
  const auto triangles = test::solid_triangles(sheet.mesh());
  std::vector<std::unique_ptr<Contender>> contenders;
  for (const SelfContactEntry& entry : entries) contenders.push_back(entry.enter(sheet));
  std::vector<Record> records(entries.size() + 1);
  for (int i = 0; i < ticks; ++i) {
    records.back().time([&] { sheet.step({}); });
    records.back().pairs.push_back(count_pairs(sheet));
    for (std::size_t k = 0; k < entries.size(); ++k) {
      records[k].time([&] { contenders[k]->tick(); });
      records[k].pairs.push_back(contact::IntersectionSearch().count(triangles, contenders[k]->positions()));
    }
  }
  print("Kerf", ticks, records.back());
  for (std::size_t k = 0; k < entries.size(); ++k) print(entries[k].setting, ticks, records[k]);
}

int fail() {
  std::fprintf(stderr,
               "usage: self_contact_bench [LETTERS [SECONDS [INTEGRATOR]]] [--without] [--obj FOLDER]; see the head of "
               "its source\n");
  return 2;
}

std::optional<Options> parse(int argc, char** argv) {
  Options options;
  for (const SelfContactScene& scene : scenes::self_contact_scenes()) options.letters += scene.letter;
  std::vector<std::string> places;
  for (int i = 1; i < argc; ++i) {
    if (std::string_view(argv[i]) == "--without") {
      options.has_contact = false;
    } else if (std::string_view(argv[i]) != "--obj") {
      places.emplace_back(argv[i]);
    } else if (++i < argc) {
      options.folder = argv[i];
    } else {
      return {};
    }
  }
  if (places.size() > 3) return {};
  if (!places.empty()) {
    if (places[0].find_first_not_of(options.letters) != std::string::npos) return {};
    options.letters = places[0];
  }
  if (places.size() > 1) {
    char* end = nullptr;
    options.seconds = std::strtod(places[1].c_str(), &end);
    if (*end != '\0' || !(options.seconds >= 0.0 && options.seconds <= 1e4)) return {};
  }
  if (places.size() > 2) {
    const auto found = integrators().find(places[2]);
    if (found == integrators().end()) return {};
    options.integrator = found->second;
  }
  return options;
}

int main_of(int argc, char** argv) {
  const std::optional<Options> options = parse(argc, argv);
  if (!options) return fail();
  std::printf(
      "| scene | vertices | ticks | pairs at the end | most, in tick | here, prototype | step of layers, mm | "
      "ms a tick, worst | J gained in a tick | flags | hash |\n|---|---|---|---|---|---|---|---|---|---|---|\n");
  const SelfContactScene* raced = nullptr;
  for (const SelfContactScene& scene : scenes::self_contact_scenes()) {
    if (options->letters.find(scene.letter) == std::string::npos) continue;
    measure(scene, *options);
    if (scene.letter == 'a') raced = &scene;
  }
  if (raced != nullptr) race(*raced, *options);
  return 0;
}

}  // namespace
}  // namespace kerf::bench

int main(int argc, char** argv) {
  return kerf::bench::main_of(argc, argv);
}
