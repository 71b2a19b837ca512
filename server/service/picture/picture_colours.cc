#include "server/service/picture/picture_colours.h"

#include <algorithm>
#include <cstddef>

#include "render/colours.h"

namespace kerf::picture {
namespace {

constexpr std::uint8_t kNoPiece = 0x9a;

}  // namespace

std::vector<std::uint8_t> piece_colours(const sheet::Topology& topology) {
  std::vector<std::uint8_t> colours(3 * topology.vertex_versions.size(), kNoPiece);
  for (std::size_t slot = 0; slot < topology.triangles.size(); ++slot) {
    if (topology.pieces[slot] == mesh::kNone) continue;
    const render::Rgb8 colour = render::piece_colour(topology.pieces[slot] + 1);
    for (const mesh::VertexId vertex : topology.triangles[slot]) {
      std::copy(colour.begin(), colour.end(), colours.begin() + 3 * vertex);
    }
  }
  return colours;
}

}  // namespace kerf::picture
