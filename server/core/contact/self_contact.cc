#include "server/core/contact/self_contact.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace kerf::contact {

using mesh::VertexId;

namespace {

constexpr double kLongestInterval = 1.3e-3;  // s, between two phases; vertices at rest fall in between
constexpr int kIdleInterval = 16;            // substeps after which a sheet that has no near pairs is looked at again
constexpr int kApartInterval = 40;           // the same where parts are flat or far apart for longer
constexpr std::size_t kSoftSweeps = 3;
constexpr int kHardSweeps = 100;
constexpr double kLookAgain = 0.1;  // -, part of its distance that a pair left to others moves before the next look
constexpr double kApproach = 0.8;   // -, the same of a pair that is too far away to be a contact
// Errors of look_at() over those of heights.
constexpr double kEdgeError = 20.0;       // of nearly parallel edges
constexpr double kSliverError = 60.0;     // of triangles that are lower than kSliver
constexpr double kSliver = 2000.0;        // -, over the error of heights
constexpr double kTriangleError = 4.0;    // of other triangles
constexpr double kEdgeThickness = 0.8;    // -, thickness between edges over that of faces
constexpr double kSlackOfAltitude = 0.3;  // -, slack of a vertex over the least altitude there
constexpr double kLeastSlack = 0.1;       // -, of the slack in the mesh as built
constexpr double kPushSpeed = 0.05;       // m/s, largest speed at which contact pushes apart
constexpr double kPushShare = 0.2;        // -, part of a lack of distance that an interval makes up for
constexpr std::array<double, 1> kWhole{1.0};

}  // namespace

void SelfContact::set(const mesh::TriangleMesh& mesh) {
  tree_.set(mesh);
  // Vertices of the mesh before may be gone.
  moved_.clear();
  strayed_.clear();
  list_.clear();
  list_.pad();
  is_indexed_ = false;
  is_apart_ = false;
  untangling_.set(tree_.features());
  base_slack_ = std::min(1.5e-3, 0.075 * mesh.base_edge_length());
  // Small triangles move together with their neighbours, so a smaller slack is enough there.
  base_slacks_.assign(static_cast<std::size_t>(mesh.num_vertices()), 0.0F);
  for (const VertexId v : tree_.features().vertices) {
    const double altitude = tree_.features().altitude_at[static_cast<std::size_t>(v)];
    base_slacks_[static_cast<std::size_t>(v)] =
        static_cast<float>(std::clamp(kSlackOfAltitude * altitude, kLeastSlack * base_slack_, base_slack_));
  }
  const auto count = static_cast<std::size_t>(mesh.num_vertices());
  path_.assign(count, 0.0F);
  slack_.assign(count, 0.0F);
  is_moved_.assign(count, 0);
  is_shifted_.assign(count, 0);
  is_strayed_.assign(count, 0);
  is_supported_.assign(count, 0);
  zone_.resize(count);
  for (std::size_t v = 0; v < count; ++v) zone_[v] = static_cast<std::int32_t>(v);
  is_zoned_.assign(count, 0);
  zones_.resize(count);
  response_.resize(count);
}

std::int64_t SelfContact::count_intersections(const linear::VertexField& x) {
  if (is_apart_) untangling_.know_none(x);
  return untangling_.count(x);
}

float SelfContact::way_of(std::size_t p) const {
  float sum = 0.0F;
  for (const VertexId v : list_.pairs[p].vertices) sum += path_[static_cast<std::size_t>(v)];
  return sum + list_.speed[p] * elapsed_;
}

void SelfContact::mark(VertexId v) {
  std::uint8_t& is_marked = is_moved_[static_cast<std::size_t>(v)];
  if (is_marked != 0) return;
  is_marked = 1;
  moved_.push_back(v);
}

void SelfContact::begin(const SelfContactStep& step, const linear::VertexField& x, linear::VertexField& v) {
  step_ = step;
  response_.begin(step.inverse_mass, step.shared);
  for (const VertexId moved : moved_) is_moved_[static_cast<std::size_t>(moved)] = 0;
  moved_.clear();
  untangling_.begin(tree_.features(), x);
  is_apart_ = untangling_.empty();
  substep_ = 0;
  interval_ = 1;
  slack_ = base_slacks_;
  set_least_slack();
  is_list_apart_ = false;
  v_list_ = v;
  is_float_set_ = false;
  stray_.resize(x.cols());
  x_then_ = x;
  v_then_ = v - step.h * step.gravity.replicate(1, v.cols());
  ++counters_.phases;
  ++phase_;
  search(x, v, 0);
  respond(x, v, 0);
  v_then_ = v;
}

void SelfContact::make_phase(linear::VertexField& x, linear::VertexField& v) {
  for (const VertexId moved : moved_) is_moved_[static_cast<std::size_t>(moved)] = 0;
  moved_.clear();
  ++counters_.phases;
  const int substep = next_phase_;
  interval_ = substep - substep_;
  find_strayed(x, v, 0.0, 1.0);
  if (!strayed_.empty()) {
    ++counters_.late;
    find_again(x);
  }
  if (list_.size() > 0) {
    follow_paths(x);
    check(x, v);
  } else {
    is_float_set_ = false;
  }
  ++phase_;
  is_apart_ = is_apart_ && list_.size() == 0;
  if (substep < step_.substeps) {
    renew_list(x, v, substep);
    respond(x, v, substep);
  }
  substep_ = substep;
  x_then_ = x;
  v_then_ = v;
}

void SelfContact::end(const linear::VertexField& x, linear::VertexField& v) {
  if (list_.size() == 0) return;
  is_float_set_ = false;
  find_contacts(x, v, step_.substeps);
  for (Contact& contact : contacts_) contact.target = 0.0;
  untangling_.clear_pushes();
  respond_softly(v);
}

void SelfContact::respond(const linear::VertexField& x, linear::VertexField& v, int substep) {
  find_contacts(x, v, substep);
  untangling_.find_pushes(tree_.features(), x, v, thickness_, step_.h * (next_phase_ - substep), response_);
  respond_softly(v);
  for (int sweep = 0; sweep < kHardSweeps; ++sweep) {
    bool has_changed = false;
    for (std::size_t c = 0; c < contacts_.size(); ++c) has_changed = respond_hard(c, v) || has_changed;
    if (!has_changed) break;
  }
}

void SelfContact::respond_softly(linear::VertexField& v) {
  for (std::size_t sweep = 0; sweep < kSoftSweeps; ++sweep) {
    for (std::size_t k = 0; k < contacts_.size(); ++k) {
      const std::size_t c = sweep % 2 == 0 ? k : contacts_.size() - 1 - k;
      if (contacts_[c].is_in_cones) respond_softly(c, v);
    }
    untangling_.push(response_, v, [this](VertexId of) { mark(of); });
    for (Support& each : supports_) support(each, v);
  }
}

void SelfContact::find_contacts(const linear::VertexField& x, const linear::VertexField& v, int substep) {
  contacts_.clear();
  supports_.clear();
  if (list_.size() == 0) {
    // While something is open, pushes come at the pace of contacts.
    const int idle = !untangling_.empty() ? std::max(1, static_cast<int>(kLongestInterval / step_.h))
                     : is_list_apart_     ? kApartInterval
                                          : kIdleInterval;
    next_phase_ = std::min(std::max(list_end_, substep + 1), substep + idle);
    return;
  }
  const double h = step_.h;
  // A step begins with half a kick, before its first drift; kicks of whole substeps come before all other drifts.
  const double since = substep == 0 ? h : (substep - substep_ - (substep_ == 0 ? 0.5 : 0.0)) * h;
  double interval = std::max(1.0, kLongestInterval / h);  // substeps
  const double ahead = h * interval;
  const double reach = thickness_ + base_slack_;
  look_at_due_pairs(x, v);
  const auto rounding = static_cast<double>(x_float_.rounding());  // m, of heights in floats
  for (std::size_t k = 0; k < due_.size(); ++k) {
    const auto p = static_cast<std::size_t>(due_[k]);
    const FeaturePair& pair = list_.pairs[p];
    // Distances change by no more than vertices move.
    const float path = due_ways_[k];
    const double about = std::abs(static_cast<double>(due_distances_[k])) - 2.0 * rounding;
    const bool is_left_to_others = due_distances_[k] < 0.0F && about > 0.0;
    const double thickness =
        pair.kind == FeaturePair::Kind::kEdgeEdge ? kEdgeThickness * pair.thickness : pair.thickness;
    // The way by which a pair that is not nearer than its thickness approaches until the next phase.
    const double approach = 1.5 * std::max(1.001 * static_cast<double>(due_closing_[k]), 0.0) * ahead;
    // Until the vertices of a pair that is no contact have moved by part of its distance, it is not looked at again.
    const auto rest = [&](double distance, double way) {
      list_.safe[p] = path + static_cast<float>(0.5 * distance);
      list_.limit[p] = path + static_cast<float>(std::max(0.0, way));
    };
    const double room = about - 1.1 * thickness - approach;
    if (is_left_to_others || room > 0.0) {
      const double error = pair.kind == FeaturePair::Kind::kEdgeEdge ? kEdgeError
                           : pair.altitude < kSliver * rounding      ? kSliverError
                                                                     : kTriangleError;
      rest(std::max(about - error * rounding, 0.0),
           std::max({about - reach, kApproach * room, is_left_to_others ? kLookAgain * about : 0.0}));
      continue;
    }
    list_.separation[p] = separation(pair.kind, positions_of(pair, x));
    list_.seen[p] = phase_;
    const Separation& s = list_.separation[p];
    rest(s.distance, kLookAgain * s.distance);
    if (s.distance > reach || s.distance == 0.0) continue;
    if (!stands_for_separation(tree_.features(), pair, s)) continue;
    Contact contact;
    contact.pair = p;
    contact.separation = s;
    Eigen::Vector3d u = Eigen::Vector3d::Zero(), before = u;
    for (std::size_t i = 0; i < 4; ++i) {
      u += s.weights[i] * v.col(pair.vertices[i]);
      before += s.weights[i] * v_then_.col(pair.vertices[i]);
    }
    const double closing = -s.normal.dot(u);
    const Eigen::Vector3d acceleration = (u - before) / since;
    if (s.distance - thickness > 1.5 * std::max(closing, 0.0) * ahead + 0.1 * thickness) {
      rest(s.distance, kApproach * (s.distance - 1.1 * thickness - 1.5 * std::max(closing, 0.0) * ahead));
      continue;
    }
    list_.limit[p] = path;
    const double inverse = response_.mobility(pair.vertices, s.weights, s.normal);
    if (!(inverse > 0.0)) continue;
    contact.mass = 1.0 / inverse;
    contact.target = thickness;  // until the interval is known
    const double left = std::max(s.distance - thickness, 0.4 * thickness);
    if (closing * interval * h > left) interval = left / (closing * h);
    const double gathering = -s.normal.dot(acceleration);
    const double gap = 0.2 * std::max(s.distance, 0.1 * thickness);
    if (gathering * interval * interval * h * h > gap) interval = std::sqrt(gap / gathering) / h;
    contacts_.push_back(contact);
  }
  // Pairs are not listed for longer than the list is good.
  const int chosen = std::clamp(static_cast<int>(interval), 1, std::max(1, list_end_ - substep));
  next_phase_ = substep + chosen;
  const double tau = chosen * h, kicked = 0.5 * (substep == 0 ? tau : tau + h);
  std::size_t kept = 0;
  for (Contact& contact : contacts_) {
    const FeaturePair& pair = list_.pairs[contact.pair];
    const Separation& s = contact.separation;
    Eigen::Vector3d u = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < 4; ++i) u += s.weights[i] * v.col(pair.vertices[i]);
    const double thickness = contact.target, gap = s.distance;
    if (gap - thickness > 1.5 * std::max(-s.normal.dot(u), 0.0) * tau + 0.05 * thickness) continue;
    contact.target =
        gap >= thickness ? (thickness - gap) / tau : std::min(kPushShare * (thickness - gap) / tau, kPushSpeed);
    contact.limit = -std::max(0.5 * gap, gap - 0.5 * thickness) / tau;
    contact.is_in_cones = is_in_cones(tree_.features(), pair, s, x);
    contacts_[kept++] = contact;
  }
  contacts_.resize(kept);
  counters_.contacts += static_cast<std::int64_t>(kept);
  find_supports(x, tau, kicked);
  set_biases(kicked);
}

void SelfContact::find_supports(const linear::VertexField& x, double duration, double kicked) {
  if (bodies_ == nullptr || bodies_->empty()) return;
  std::vector<std::uint8_t>& is_seen = is_supported_;
  for (const Contact& contact : contacts_) {
    if (!contact.is_in_cones) continue;
    for (const VertexId v : list_.pairs[contact.pair].vertices) {
      if (is_seen[static_cast<std::size_t>(v)] != 0 || response_.inverse_mass(v) == 0.0) continue;
      is_seen[static_cast<std::size_t>(v)] = 1;
      for (const PreparedCollider& body : bodies_->colliders()) {
        const Proximity near = body.query(x.col(v));
        const double gap = near.distance - bodies_->thickness(static_cast<std::size_t>(v));
        if (gap > thickness_) continue;
        const double inverse = response_.mobility(std::array{v}, kWhole, near.normal);
        if (!(inverse > 0.0)) continue;
        Support& added = supports_.emplace_back();
        added.vertex = v;
        added.normal = near.normal;
        added.friction = body.friction();
        added.mass = 1.0 / inverse;
        added.target = std::min(-gap / duration, ContactSolver::kExitSpeed);
        added.bias = kicked * step_.gravity;
      }
    }
  }
  for (const Contact& contact : contacts_) {
    for (const VertexId v : list_.pairs[contact.pair].vertices) is_seen[static_cast<std::size_t>(v)] = 0;
  }
}

void SelfContact::set_biases(double kicked) {
  for (const Support& each : supports_) is_supported_[static_cast<std::size_t>(each.vertex)] = 1;
  for (Contact& contact : contacts_) {
    const FeaturePair& pair = list_.pairs[contact.pair];
    double falling = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      const VertexId v = pair.vertices[i];
      const bool falls = response_.inverse_mass(v) > 0.0 && is_supported_[static_cast<std::size_t>(v)] == 0;
      falling += falls ? contact.separation.weights[i] : 0.0;
    }
    contact.bias = falling * kicked * step_.gravity;
  }
  for (const Support& each : supports_) is_supported_[static_cast<std::size_t>(each.vertex)] = 0;
}

void SelfContact::apply(const FeaturePair& pair, const Separation& separation, const Eigen::Vector3d& impulse,
                        linear::VertexField& v) {
  response_.push(pair.vertices, separation.weights, impulse, [&](VertexId vertex, const Eigen::Vector3d& change) {
    v.col(vertex) += change;
    mark(vertex);
  });
}

void SelfContact::respond_softly(std::size_t index, linear::VertexField& v) {
  Contact& contact = contacts_[index];
  const FeaturePair& pair = list_.pairs[contact.pair];
  const Separation& s = contact.separation;
  Eigen::Vector3d u = contact.bias;
  for (std::size_t i = 0; i < 4; ++i) u += s.weights[i] * v.col(pair.vertices[i]);
  const double normal = s.normal.dot(u);
  const double impulse = std::max(0.0, contact.impulse + contact.mass * (contact.target - normal));
  if (impulse == 0.0 && contact.impulse == 0.0) return;
  Eigen::Vector3d friction = contact.friction - contact.mass * (u - normal * s.normal);
  const double most = friction_ * impulse, size = friction.norm();
  if (size > most) friction *= most / size;
  apply(pair, s, (impulse - contact.impulse) * s.normal + friction - contact.friction, v);
  contact.impulse = impulse;
  contact.friction = friction;
}

void SelfContact::support(Support& on, linear::VertexField& v) {
  const Eigen::Vector3d u = v.col(on.vertex) + on.bias;
  const double normal = on.normal.dot(u);
  const double impulse = std::max(0.0, on.impulse + on.mass * (on.target - normal));
  if (impulse == 0.0 && on.impulse == 0.0) return;
  Eigen::Vector3d friction = on.friction_impulse - on.mass * (u - normal * on.normal);
  const double most = on.friction * impulse, size = friction.norm();
  if (size > most) friction *= most / size;
  response_.push(std::array{on.vertex}, kWhole, (impulse - on.impulse) * on.normal + friction - on.friction_impulse,
                 [&](VertexId vertex, const Eigen::Vector3d& change) {
                   v.col(vertex) += change;
                   mark(vertex);
                 });
  on.impulse = impulse;
  on.friction_impulse = friction;
}

bool SelfContact::respond_hard(std::size_t index, linear::VertexField& v) {
  Contact& contact = contacts_[index];
  const FeaturePair& pair = list_.pairs[contact.pair];
  const Separation& s = contact.separation;
  Eigen::Vector3d u = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < 4; ++i) u += s.weights[i] * v.col(pair.vertices[i]);
  const double lack = contact.limit - s.normal.dot(u);
  if (!(lack > -1e-3 * contact.limit)) return false;
  apply(pair, s, contact.mass * lack * s.normal, v);
  return true;
}

}  // namespace kerf::contact
