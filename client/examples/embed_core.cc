// Uses Kerf without a server: a hanging cloth, cut along a curve while it moves, and written as a Wavefront OBJ file.
//
//   embed_core [FILE.obj]

#include <array>
#include <cstdio>
#include <fstream>

#include "server/core/sheet/sheet.h"

namespace {

namespace sheet = kerf::sheet;

kerf::Result<sheet::Sheet> hang_cloth() {
  sheet::SheetConfig config;
  config.mesh = sheet::GridSource{.columns = 40, .rows = 40, .width = 1.0, .height = 1.0};
  const kerf::Result<kerf::fem::Material> silk = kerf::fem::find_preset("silk");
  if (!silk.ok()) return silk.error();
  config.material = *silk;
  config.pins.emplace_back(sheet::RegionEdge::kCorners);
  return sheet::Sheet::create(config);
}

// Writes the sheet's present shape; vertices are numbered 1, 2, 3, ... in the order of their lines.
bool write_obj(const sheet::Sheet& cloth, const char* path) {
  std::ofstream file(path);
  for (const auto& position : cloth.state().x.colwise()) file << "v " << position.transpose() << "\n";
  for (kerf::mesh::TriangleId slot = 0; slot < cloth.mesh().num_triangle_slots(); ++slot) {
    if (!cloth.mesh().is_solid(slot)) continue;
    const auto& [a, b, c] = cloth.mesh().vertices(slot);
    file << "f " << a + 1 << " " << b + 1 << " " << c + 1 << "\n";
  }
  return static_cast<bool>(file.flush());
}

int refuse(const kerf::Error& error) {
  std::fprintf(stderr, "%s [%s] (%s)\n", error.message.c_str(), error.field.c_str(), error.reason.c_str());
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  kerf::Result<sheet::Sheet> cloth = hang_cloth();
  if (!cloth.ok()) return refuse(cloth.error());
  for (int tick = 0; tick < 30; ++tick) cloth->step({});

  // A command takes effect at the start of its tick: wholly, or not at all.
  sheet::Cut across;
  across.curve = kerf::cut::CubicBezier{{{-0.1, 0.4}, {0.3, 0.7}, {0.7, 0.2}, {1.1, 0.5}}};
  const sheet::TickReport report = cloth->step(std::array<sheet::Command, 1>{across});
  const kerf::Result<sheet::CommandReply>& reply = report.replies.front();
  if (!reply.ok()) return refuse(reply.error());
  std::printf("tick %lld: cut into %d pieces\n", static_cast<long long>(reply->tick), reply->cut->report.pieces);

  for (int tick = 0; tick < 29; ++tick) cloth->step({});
  std::printf("tick %lld: %d vertices, %d triangles, kinetic energy %.3g J, state hash %016llx\n",
              static_cast<long long>(cloth->tick()), cloth->mesh().num_vertices(), cloth->mesh().num_solid_triangles(),
              cloth->energies().kinetic, static_cast<unsigned long long>(cloth->state_hash()));
  if (argc > 1 && !write_obj(*cloth, argv[1])) {
    std::fprintf(stderr, "%s cannot be written\n", argv[1]);
    return 1;
  }
  return 0;
}
