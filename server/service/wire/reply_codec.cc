#include "server/service/wire/reply_codec.h"

#include <array>
#include <cstdio>

#include "server/base/check.h"
#include "server/service/wire/geometry_codec.h"

namespace kerf::wire {

std::string encode_hash(std::uint64_t hash) {
  std::array<char, 17> text{};
  std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(hash));
  return text.data();
}

namespace {

void encode_quality(const cut::CutQuality& quality, v1::CutQuality& message) {
  message.set_mean_min_angle_deg(quality.mean_min_angle_deg);
  message.set_max_aspect(quality.max_aspect);
  message.set_mean_aspect(quality.mean_aspect);
  message.set_max_edge_ratio(quality.max_edge_ratio);
  message.set_mean_edge_ratio(quality.mean_edge_ratio);
  message.set_min_height_m(quality.min_height_m);
  message.set_below_angle(quality.triangles_below_angle);
  message.set_below_contract(quality.triangles_below_contract);
  message.set_corners_total(quality.num_corners);
  message.set_elsewhere_min_angle_deg(quality.elsewhere_min_angle_deg);
  v1::StrandQuality& strands = *message.mutable_strands();
  strands.set_below_angle(quality.strands.triangles_below);
  strands.set_narrow_below_angle(quality.strands.narrow_below);
  strands.set_asked_angle_deg(quality.strands.asked_angle_deg);
  strands.set_min_angle_deg(quality.strands.min_angle_deg);
  strands.set_narrow_min_angle_deg(quality.strands.narrow_min_angle_deg);
  for (const cut::SharpCorner& corner : quality.corners) {
    v1::SharpCorner& corner_message = *message.add_corners();
    encode_vector(corner.position, *corner_message.mutable_position());
    corner_message.set_angle_deg(corner.angle_deg);
    corner_message.set_elements_below(corner.triangles_below);
  }
}

}  // namespace

v1::CutResult encode_cut_result(const scene::CommandReply& reply, const scene::CutReply& cut) {
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
  result.set_min_angle_deg(report.quality.min_angle_deg);
  encode_quality(report.quality, *result.mutable_quality());
  result.set_refinement_stopped(report.refinement_stopped);
  result.set_closed_gaps(report.closed_gaps);
  result.set_widest_gap_m(report.widest_gap_m);
  result.set_merged_segments(report.merged_segments);
  result.set_joined_ends(report.joins.joined_ends);
  result.set_widest_join_m(report.joins.widest_join_m);
  result.set_near_ends(report.joins.near_ends);
  result.set_nearest_end_m(report.joins.nearest_end_m);
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
  if (cut.removed_mass) {
    v1::Removed& removed = *result.mutable_removed();
    removed.set_area_m2(report.removed_area_m2);
    removed.set_mass_kg(*cut.removed_mass);
    removed.set_pieces(report.removed_pieces);
    removed.set_vertices(report.removed_vertices);
    removed.set_triangles(report.removed_triangles);
  }
  for (const scene::SplitPiece& split : cut.split_pieces) {
    v1::PieceSplit& message = *result.add_split_pieces();
    message.set_piece(split.id);
    for (const scene::Piece& child : split.children) *message.add_children() = encode_piece(child);
  }
  return result;
}

std::vector<v1::CutResult> encode_cut_results(const scene::CommandReply& reply) {
  std::vector<v1::CutResult> results;
  if (reply.cut) results.push_back(encode_cut_result(reply, *reply.cut));
  for (const scene::CutReply& cut : reply.batch) results.push_back(encode_cut_result(reply, cut));
  return results;
}

v1::Piece encode_piece(const scene::Piece& piece) {
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

void encode_flags(const fem::FlagCounts& counts, google::protobuf::Map<std::string, std::int64_t>& message) {
  for (std::size_t bit = 0; bit < counts.size(); ++bit) {
    if (counts[bit] > 0) message[std::string(fem::kStepFlagNames[bit])] = counts[bit];
  }
}

}  // namespace kerf::wire
