#include "server/wire/reply_codec.h"

#include <array>
#include <cstdio>

#include "server/base/check.h"

namespace kerf::wire {

std::string encode_hash(std::uint64_t hash) {
  std::array<char, 17> text{};
  std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(hash));
  return text.data();
}

v1::CutResult encode_cut_result(const sheet::CommandReply& reply) {
  KERF_CHECK(reply.cut.has_value(), "the reply to something that is no cut");
  const cut::CutReport& report = reply.cut->report;
  v1::CutResult result;
  result.set_status(reply.cut->status == cut::CutStatus::kApplied ? v1::CutResult::APPLIED
                                                                  : v1::CutResult::NO_INTERSECTION);
  result.set_tick(reply.tick);
  result.set_topology_version(reply.topology_version);
  result.set_pieces(report.pieces);
  result.set_new_vertices(report.new_vertices);
  result.set_new_triangles(report.new_triangles);
  result.set_crossed_triangles(report.crossed_triangles);
  result.set_deviation_m(report.deviation_m);
  result.set_min_angle_deg(report.min_angle_deg);
  result.set_state_hash(encode_hash(reply.state_hash));
  for (const std::string& warning : reply.cut->warnings) result.add_warnings(warning);
  for (const cut::ViewLayer& layer : report.layers) {
    v1::CutLayer& message = *result.add_layers();
    message.set_piece(layer.piece);
    message.set_length_m(layer.length_m);
    message.set_nearest_m(layer.nearest_m);
    message.set_farthest_m(layer.farthest_m);
    message.set_faces_camera(layer.faces_camera);
  }
  return result;
}

v1::Energies encode_energies(const sheet::Energies& energies) {
  v1::Energies message;
  message.set_kinetic_j(energies.kinetic);
  message.set_membrane_j(energies.membrane);
  message.set_bending_j(energies.bending);
  message.set_gravity_j(energies.gravity);
  return message;
}

}  // namespace kerf::wire
