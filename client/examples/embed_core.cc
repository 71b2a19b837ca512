// Uses Kerf without a server: hangs a cloth, cuts it while it moves, and writes it as a Wavefront OBJ file.
//
//   embed_core [FILE.obj]

#include <array>
#include <cstdio>
#include <fstream>

#include <kerf/kerf.h>

namespace scene = kerf::scene;
namespace sheet = kerf::sheet;

int main(int argc, char** argv) {
  scene::SheetConfig config;
  config.mesh = scene::GridSource{.columns = 40, .rows = 40, .width = 1.0, .height = 1.0};
  config.material = kerf::fem::find_preset("silk").value();
  config.pins.emplace_back(scene::RegionEdge::kCorners);
  kerf::Result<sheet::Sheet> cloth = sheet::Sheet::create(config);
  if (!cloth.ok()) return std::fprintf(stderr, "%s\n", cloth.error().message.c_str()), 1;
  for (int tick = 0; tick < 30; ++tick) cloth->step({});

  // A command takes effect at the start of its tick: wholly, or not at all.
  scene::Cut across;
  across.curve = kerf::cut::CubicBezier{{{-0.1, 0.4}, {0.3, 0.7}, {0.7, 0.2}, {1.1, 0.5}}};
  const sheet::TickReport report = cloth->step(std::array<scene::Command, 1>{across});
  const kerf::Result<scene::CommandReply>& reply = report.replies.front();
  if (!reply.ok()) return std::fprintf(stderr, "%s\n", reply.error().message.c_str()), 1;
  std::printf("tick %lld: cut into %d pieces\n", static_cast<long long>(reply->tick), reply->cut->report.pieces);

  for (int tick = 0; tick < 29; ++tick) cloth->step({});
  const auto now = cloth->snapshot();
  std::printf("tick %lld: %d vertices, %d triangles, kinetic energy %.3g J, state hash %016llx\n",
              static_cast<long long>(now->tick), static_cast<int>(now->positions.cols()), now->topology->num_triangles,
              cloth->energies().kinetic, static_cast<unsigned long long>(cloth->state_hash()));
  if (argc < 2) return 0;

  std::ofstream file(argv[1]);  // numbers the vertices 1, 2, 3, ... in the order of their lines
  for (const auto& position : now->positions.colwise()) file << "v " << position.transpose() << "\n";
  for (const auto& [a, b, c] : now->topology->triangles) {
    if (a != kerf::mesh::kNone) file << "f " << a + 1 << " " << b + 1 << " " << c + 1 << "\n";
  }
  return file.flush() ? 0 : 1;
}
