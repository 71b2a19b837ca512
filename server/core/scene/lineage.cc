#include "server/core/scene/lineage.h"

#include <algorithm>
#include <map>

#include "server/core/scene/sheet_materials.h"

namespace kerf::scene {

namespace {

// Returns the sum of several pieces, as one piece without label.
Piece sum_of(const std::vector<Piece>& parts, const PieceBirth& birth) {
  Piece sum;
  sum.birth = birth;
  sum.label = mesh::kNone;
  for (const Piece& part : parts) {
    sum.num_triangles += part.num_triangles;
    sum.area += part.area;
    sum.mass += part.mass;
    sum.centroid += part.area * part.centroid;
    sum.world_centroid += part.area * part.world_centroid;
  }
  if (sum.area > 0.0) {
    sum.centroid /= sum.area;
    sum.world_centroid /= sum.area;
  }
  return sum;
}

}  // namespace

Lineage::Lineage(std::int32_t num_pieces) : next_id_(std::int64_t{num_pieces} + 1) {
  reset(num_pieces);
}

LineageChange Lineage::split(const std::vector<std::int32_t>& split_from, const std::vector<std::int32_t>& vanished,
                             std::int64_t cut) {
  LineageChange change;
  change.num_pieces_before = static_cast<std::int32_t>(pieces_.size());
  change.num_pieces_after = change.num_pieces_before + static_cast<std::int32_t>(split_from.size());
  std::map<std::int32_t, std::vector<std::int32_t>> parts;  // labels of all parts, by label of the piece that fell
                                                            // apart
  for (std::size_t i = 0; i < split_from.size(); ++i) {
    std::vector<std::int32_t>& labels = parts[split_from[i]];
    if (labels.empty()) labels.push_back(split_from[i]);
    labels.push_back(change.num_pieces_before + static_cast<std::int32_t>(i));
  }
  for (const auto& [parent, labels] : parts) {
    const PieceBirth& ended = pieces_[static_cast<std::size_t>(parent)];
    change.ended.emplace_back(parent, ended);
    for (const std::int32_t label : labels) change.born.emplace_back(label, PieceBirth{next_id_++, ended.id, cut});
  }
  for (const std::int32_t label : vanished) {
    change.given_up.emplace_back(label, pieces_[static_cast<std::size_t>(label)]);
  }
  redo(change);
  return change;
}

void Lineage::redo(const LineageChange& change) {
  pieces_.resize(static_cast<std::size_t>(change.num_pieces_after));
  for (const auto& [label, birth] : change.born) pieces_[static_cast<std::size_t>(label)] = birth;
  for (const auto& [label, birth] : change.given_up) {
    pieces_[static_cast<std::size_t>(label)] = pieces_.back();
    pieces_.pop_back();
  }
}

void Lineage::undo(const LineageChange& change) {
  for (auto gone = change.given_up.rbegin(); gone != change.given_up.rend(); ++gone) {
    const auto label = static_cast<std::size_t>(gone->first);
    pieces_.push_back(label < pieces_.size() ? pieces_[label] : gone->second);
    pieces_[label] = gone->second;
  }
  pieces_.resize(static_cast<std::size_t>(change.num_pieces_before));
  for (const auto& [label, birth] : change.ended) pieces_[static_cast<std::size_t>(label)] = birth;
}

void Lineage::reset(std::int32_t num_pieces) {
  pieces_.clear();
  for (std::int32_t label = 0; label < num_pieces; ++label) pieces_.push_back({std::int64_t{label} + 1, 0, 0});
}

std::vector<Piece> measure_pieces(const mesh::TriangleMesh& mesh, const std::vector<PieceBirth>& births,
                                  const linear::VertexField& x, const std::vector<fem::Material>& materials) {
  std::vector<Piece> pieces(births.size());
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t)) continue;
    Piece& piece = pieces[static_cast<std::size_t>(mesh.piece(t))];
    const double area = mesh.area(t);
    ++piece.num_triangles;
    piece.area += area;
    piece.mass += surface_density(mesh, t, materials) * area;
    for (const mesh::VertexId v : mesh.vertices(t)) {
      piece.centroid += area / 3.0 * mesh.rest_position(v);
      piece.world_centroid += area / 3.0 * x.col(v);
    }
  }
  for (std::size_t label = 0; label < pieces.size(); ++label) {
    Piece& piece = pieces[label];
    piece.birth = births[label];
    piece.label = static_cast<std::int32_t>(label);
    piece.centroid /= piece.area;
    piece.world_centroid /= piece.area;
  }
  return pieces;
}

std::vector<std::vector<SplitPiece>> describe_splits(const std::vector<LineageChange>& changes,
                                                     const std::vector<Piece>& now) {
  std::map<std::int64_t, Piece> known;
  for (const Piece& piece : now) known.emplace(piece.birth.id, piece);
  std::vector<std::vector<SplitPiece>> splits(changes.size());
  for (std::size_t i = changes.size(); i-- > 0;) {
    for (const auto& [label, gone] : changes[i].given_up) {
      Piece nothing;
      nothing.birth = gone;
      nothing.label = mesh::kNone;
      known[gone.id] = nothing;
      splits[i].push_back({gone.id, {}});
    }
    for (const auto& [parent_label, ended] : changes[i].ended) {
      SplitPiece split;
      split.id = ended.id;
      for (const auto& [label, birth] : changes[i].born) {
        if (birth.parent == ended.id) split.children.push_back(known.at(birth.id));
      }
      known[ended.id] = sum_of(split.children, ended);
      splits[i].push_back(std::move(split));
    }
    std::sort(splits[i].begin(), splits[i].end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  }
  return splits;
}

}  // namespace kerf::scene
