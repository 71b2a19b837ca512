#include "server/wire/reply_codec.h"

#include <array>
#include <cstdio>

#include "server/wire/geometry_codec.h"

namespace kerf::wire {

std::string encode_hash(std::uint64_t hash) {
  std::array<char, 17> text{};
  std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(hash));
  return text.data();
}

v1::CutResult encode_cut_result(const sheet::CommandReply& reply, const sheet::CutReply& cut) {
  const cut::CutReport& report = cut.report;
  v1::CutResult result;
  result.set_status(cut.status == cut::CutStatus::kApplied ? v1::CutResult::APPLIED : v1::CutResult::NO_INTERSECTION);
  result.set_tick(reply.tick);
  result.set_topology_version(reply.topology_version);
  result.set_pieces(report.pieces);
  result.set_new_vertices(report.new_vertices);
  result.set_new_triangles(report.new_triangles);
  result.set_crossed_triangles(report.crossed_triangles);
  result.set_deviation_m(report.deviation_m);
  result.set_min_angle_deg(report.min_angle_deg);
  result.set_state_hash(encode_hash(reply.state_hash));
  for (const std::string& warning : cut.warnings) result.add_warnings(warning);
  for (const cut::ViewLayer& layer : report.layers) {
    v1::CutLayer& message = *result.add_layers();
    message.set_piece(layer.piece);
    message.set_length_m(layer.length_m);
    message.set_nearest_m(layer.nearest_m);
    message.set_farthest_m(layer.farthest_m);
    message.set_faces_camera(layer.faces_camera);
  }
  for (const sheet::SplitPiece& split : cut.split_pieces) {
    v1::PieceSplit& message = *result.add_split_pieces();
    message.set_piece(split.id);
    for (const sheet::Piece& child : split.children) *message.add_children() = encode_piece(child);
  }
  return result;
}

std::vector<v1::CutResult> encode_cut_results(const sheet::CommandReply& reply) {
  std::vector<v1::CutResult> results;
  if (reply.cut) results.push_back(encode_cut_result(reply, *reply.cut));
  for (const sheet::CutReply& cut : reply.batch) results.push_back(encode_cut_result(reply, cut));
  return results;
}

v1::Piece encode_piece(const sheet::Piece& piece) {
  v1::Piece message;
  message.set_id(piece.birth.id);
  message.set_parent(piece.birth.parent);
  message.set_cut_number(piece.birth.cut);
  message.set_label(piece.label);
  message.set_num_triangles(piece.num_triangles);
  message.set_area_m2(piece.area);
  message.set_mass_kg(piece.mass);
  encode_vector(piece.centroid, *message.mutable_centroid());
  encode_vector(piece.world_centroid, *message.mutable_world_centroid());
  return message;
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
