#include "server/core/fem/model/local_inertia.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <tuple>

#include <Eigen/Geometry>

#include "server/base/interruption.h"

namespace kerf::fem {

using mesh::VertexId;

namespace {

// Visits the parts with the largest row sums. They are as many as needed for the row sums of the other parts to add up
// to at most `limit`, N/m.
template <typename Visit>
void for_each_stiff(std::vector<PartAtVertex>& parts, double limit, const Visit& visit) {
  std::sort(parts.begin(), parts.end(), [](const PartAtVertex& a, const PartAtVertex& b) {
    return std::tuple(a.row_sum, a.part) < std::tuple(b.row_sum, b.part);
  });
  double sum = 0.0;
  for (const PartAtVertex& each : parts) {
    sum += each.row_sum;
    if (sum > limit) visit(each.part);
  }
}

}  // namespace

void LocalInertia::reserve(std::size_t num_vertices) {
  if (num_vertices <= cluster_of_.capacity()) return;
  const std::size_t room = num_vertices + num_vertices / 4;
  cluster_of_.reserve(room);
  held_.reserve(room);
  region_.resize(room);
}

void LocalInertia::rebuild(const Model& model, const InertiaTerms& terms) {
  terms_ = terms;
  wanted_.clear();
  cluster_of_.clear();
  clusters_.clear();
  free_.clear();
  reserve(static_cast<std::size_t>(model.num_vertices()));
  begin_update(model);
  for (VertexId v = 0; v < model.num_vertices(); ++v) {
    interruption_point();
    find_wanted(model, v);
  }
  end_update(model);
}

void LocalInertia::follow(const Model& model, const InertiaTerms& terms) {
  if (terms != terms_) return rebuild(model, terms);
  begin_update(model);
  const auto update = [&](std::span<const VertexId> changed) {
    for (const VertexId v : changed) {
      if (cluster_of_[static_cast<std::size_t>(v)] != mesh::kNone) dissolve(cluster_of_[static_cast<std::size_t>(v)]);
      find_wanted(model, v);
    }
  };
  update(model.changed_rows());
  update(model.masses().changed());
  end_update(model);
}

void LocalInertia::begin_update(const Model& model) {
  const auto n = static_cast<std::size_t>(model.num_vertices());
  region_.clear();
  region_.resize(std::max(n, cluster_of_.size()));
  for (std::size_t v = n; v < cluster_of_.size(); ++v) {
    if (cluster_of_[v] != mesh::kNone) dissolve(cluster_of_[v]);
    wanted_.erase(static_cast<VertexId>(v));
  }
  cluster_of_.resize(n, mesh::kNone);
}

void LocalInertia::end_update(const Model& model) {
  gather_region(model);
  form_clusters(model);
  set_order();
}

void LocalInertia::dissolve(std::int32_t cluster) {
  std::unique_ptr<InertiaCluster>& gone = clusters_[static_cast<std::size_t>(cluster)];
  for (const VertexId v : gone->vertices()) {
    cluster_of_[static_cast<std::size_t>(v)] = mesh::kNone;
    region_.insert(v);
  }
  gone.reset();
  free_.push_back(cluster);
}

void LocalInertia::find_wanted(const Model& model, VertexId v) {
  row_.clear();
  const double mass = model.mass()[static_cast<std::size_t>(v)];
  const bool is_split = terms_.bending_limit > 0.0;
  const double of_membrane = membrane_row_sum(model, v);
  const double of_bending = bending_row_sum(model, v);
  const auto want = [this](const StiffPart& part) { row_.push_back(part); };
  if (of_membrane + (is_split ? 0.0 : of_bending) > terms_.limit * mass) {
    find_triangles_at(model, v, parts_);
    if (!is_split) {
      find_bending_at(model, v, slots_, bending_);
      parts_.insert(parts_.end(), bending_.begin(), bending_.end());
    }
    for_each_stiff(parts_, terms_.limit * mass, want);
  }
  if (is_split && of_bending > terms_.bending_limit * mass) {
    find_bending_at(model, v, slots_, parts_);
    for_each_stiff(parts_, terms_.bending_limit * mass, want);
  }
  std::sort(row_.begin(), row_.end());
  row_.erase(std::unique(row_.begin(), row_.end()), row_.end());
  if (row_.empty()) {
    wanted_.erase(v);
  } else {
    wanted_[v] = row_;
    region_.insert(v);
  }
}

// Collects the stiff parts of the region, which grows by the clusters that they reach.
void LocalInertia::gather_region(const Model& model) {
  stiff_.clear();
  for (std::size_t i = 0; i < region_.size(); ++i) {
    const VertexId v = region_.members()[i];
    const auto wanted = wanted_.find(v);
    if (wanted == wanted_.end()) continue;
    for (const StiffPart& part : wanted->second) {
      stiff_.push_back(part);
      for (const VertexId w : part.vertices(model)) {
        if (w == mesh::kNone) continue;
        region_.insert(w);
        const std::int32_t cluster = cluster_of_[static_cast<std::size_t>(w)];
        if (cluster != mesh::kNone) dissolve(cluster);
      }
    }
  }
  std::sort(stiff_.begin(), stiff_.end());
  stiff_.erase(std::unique(stiff_.begin(), stiff_.end()), stiff_.end());
}

std::int32_t LocalInertia::root(std::int32_t place) {
  while (parent_[static_cast<std::size_t>(place)] != place) {
    std::int32_t& up = parent_[static_cast<std::size_t>(place)];
    up = parent_[static_cast<std::size_t>(up)];
    place = up;
  }
  return place;
}

void LocalInertia::form_clusters(const Model& model) {
  parent_.resize(region_.size());
  std::iota(parent_.begin(), parent_.end(), 0);
  const auto first_of = [&](const StiffPart& part) { return region_.place(part.vertices(model)[0]); };
  for (const StiffPart& part : stiff_) {
    for (const VertexId w : part.vertices(model)) {
      if (w != mesh::kNone) parent_[static_cast<std::size_t>(root(region_.place(w)))] = root(first_of(part));
    }
  }
  // Parts by cluster and members by cluster, both ascending.
  std::vector<std::pair<std::int32_t, StiffPart>> parts;
  parts.reserve(stiff_.size());
  std::vector<std::pair<std::int32_t, VertexId>> members;
  for (const StiffPart& part : stiff_) {
    const std::int32_t of = root(first_of(part));
    parts.emplace_back(of, part);
    for (const VertexId w : part.vertices(model)) {
      if (w != mesh::kNone) members.emplace_back(of, w);
    }
  }
  std::stable_sort(parts.begin(), parts.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::sort(members.begin(), members.end());
  members.erase(std::unique(members.begin(), members.end()), members.end());
  std::vector<VertexId> own;
  auto next_member = members.begin();
  for (auto first = parts.begin(); first != parts.end();) {
    const std::int32_t of = first->first;
    row_.clear();
    for (; first != parts.end() && first->first == of; ++first) row_.push_back(first->second);
    own.clear();
    for (; next_member != members.end() && next_member->first == of; ++next_member) own.push_back(next_member->second);
    std::int32_t id = static_cast<std::int32_t>(clusters_.size());
    if (free_.empty()) {
      clusters_.emplace_back();
    } else {
      id = free_.back();
      free_.pop_back();
    }
    clusters_[static_cast<std::size_t>(id)] = std::make_unique<InertiaCluster>(model, own, row_, terms_.added);
    for (const VertexId v : own) cluster_of_[static_cast<std::size_t>(v)] = id;
  }
}

void LocalInertia::set_order() {
  ordered_.clear();
  num_vertices_ = num_entries_ = largest_ = 0;
  for (const std::unique_ptr<InertiaCluster>& cluster : clusters_) {
    if (cluster == nullptr) continue;
    ordered_.push_back(cluster.get());
    num_vertices_ += cluster->vertices().size();
    num_entries_ += cluster->num_entries();
    largest_ = std::max(largest_, cluster->vertices().size());
  }
  std::sort(ordered_.begin(), ordered_.end(),
            [](const InertiaCluster* a, const InertiaCluster* b) { return a->lowest() < b->lowest(); });
  held_.resize(cluster_of_.size(), 0);
  held_of_cluster_.resize(largest_);
  values_.resize(largest_ / 4 + 1);
}

void LocalInertia::hold(std::span<const Pin> pins) {
  if (empty()) return;
  for (const Pin& pin : pins) {
    std::uint8_t& held = held_[static_cast<std::size_t>(pin.vertex)];
    held = 0;
    for (std::size_t c = 0; c < 3; ++c) held |= static_cast<std::uint8_t>(pin.fixed[c] ? 1U << c : 0U);
  }
  for (InertiaCluster* const cluster : ordered_) {
    const std::span<const VertexId> vertices = cluster->vertices();
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      held_of_cluster_[i] = held_[static_cast<std::size_t>(vertices[i])];
    }
    cluster->hold({held_of_cluster_.data(), vertices.size()});
  }
  for (const Pin& pin : pins) held_[static_cast<std::size_t>(pin.vertex)] = 0;
}

double LocalInertia::mobility(const Model& model, const Grab& grab) const {
  double sum = 0.0;
  std::array<const InertiaCluster*, 3> seen{};
  std::vector<linear::Lanes16<double>> response;
  for (std::size_t k = 0; k < 3; ++k) {
    const VertexId v = grab.vertices[k];
    if (v == mesh::kNone) continue;
    const double weight = grab.weights[static_cast<Eigen::Index>(k)];
    const InertiaCluster* const cluster = cluster_of(v);
    if (cluster == nullptr) sum += weight * weight * model.inverse_mass()[static_cast<std::size_t>(v)];
    if (cluster == nullptr || std::find(seen.begin(), seen.end(), cluster) != seen.end()) continue;
    seen[k] = cluster;
    const std::span<const VertexId> vertices = cluster->vertices();
    response.assign(vertices.size() / 4 + 1, {});
    double* const values = response.front().lane.data();
    const auto weight_at = [&](VertexId at) {
      double all = 0.0;
      for (std::size_t m = 0; m < 3; ++m) {
        if (grab.vertices[m] == at) all += grab.weights[static_cast<Eigen::Index>(m)];
      }
      return all;
    };
    for (std::size_t i = 0; i < vertices.size(); ++i) std::fill_n(values + 4 * i, 3, weight_at(vertices[i]));
    cluster->solve(values);
    std::array<double, 3> of_cluster{};
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) of_cluster[c] += weight_at(vertices[i]) * values[4 * i + c];
    }
    sum += *std::max_element(of_cluster.begin(), of_cluster.end());
  }
  return sum;
}

double LocalInertia::added_energy(const linear::VertexField& v) const {
  double doubled = 0.0;
  for (const InertiaCluster* const cluster : clusters()) {
    cluster->for_each_added([&](VertexId i, VertexId j, double entry) {
      doubled += (i == j ? 1.0 : 2.0) * entry * v.col(i).dot(v.col(j));
    });
  }
  return 0.5 * doubled;
}

void LocalInertia::share_impulses(const Model& model, linear::VertexField& v) const {
  for (const InertiaCluster* const cluster : clusters()) {
    const std::span<const VertexId> vertices = cluster->vertices();
    double* const values = values_.front().lane.data();
    const auto value = [values](std::size_t i) { return Eigen::Map<Eigen::Vector3d>(values + 4 * i); };
    Eigen::Vector3d momentum = Eigen::Vector3d::Zero();  // N s, momentum that the solve loses to rounding
    double mass = 0.0;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const double mass_of_vertex = model.mass()[static_cast<std::size_t>(vertices[i])];
      value(i) = mass_of_vertex * v.col(vertices[i]);
      values[4 * i + 3] = 0.0;
      momentum += value(i);
      mass += mass_of_vertex;
    }
    cluster->solve(values);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      momentum -= model.mass()[static_cast<std::size_t>(vertices[i])] * value(i);
    }
    const Eigen::Vector3d lost = cluster->is_held() ? Eigen::Vector3d::Zero() : Eigen::Vector3d(momentum / mass);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      for (Eigen::Index c = 0; c < 3; ++c) {
        if ((cluster->held()[i] >> c & 1U) == 0) v(c, vertices[i]) = value(i)[c] + lost[c];
      }
    }
  }
}

Eigen::Vector3d LocalInertia::added_spin(const State& state) const {
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();
  for (const InertiaCluster* const cluster : clusters()) {
    cluster->for_each_added([&](VertexId i, VertexId j, double entry) {
      spin += entry * Eigen::Vector3d(state.x.col(i)).cross(Eigen::Vector3d(state.v.col(j)));
      if (i != j) spin += entry * Eigen::Vector3d(state.x.col(j)).cross(Eigen::Vector3d(state.v.col(i)));
    });
  }
  return spin;
}

}  // namespace kerf::fem
