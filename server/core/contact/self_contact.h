#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/core/contact/contact_solver.h"
#include "server/core/contact/feature_pair.h"
#include "server/core/contact/feature_tree.h"
#include "server/core/contact/impulse_response.h"
#include "server/core/contact/pair_index.h"
#include "server/core/contact/pair_looks.h"
#include "server/core/contact/shared_inertia.h"
#include "server/core/contact/untangling.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/ids.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::contact {

// Counts since the object was constructed.
struct SelfContactCounters {
  std::int64_t phases = 0;
  std::int64_t searches = 0;   // lists of pairs made
  std::int64_t late = 0;       // lists that had become too old before the phase that looked
  std::int64_t pairs = 0;      // listed, summed over searches
  std::int64_t contacts = 0;   // pairs that responded, summed over phases
  std::int64_t repairs = 0;    // pairs that failed a check and were put right one by one
  std::int64_t zones = 0;      // pairs that failed again and moved as one with their neighbours
  std::int64_t unsettled = 0;  // pairs that still failed when the rounds were used up
};

// Settings that all phases of a step have in common.
struct SelfContactStep {
  double h = 0.0;                          // s, length of a substep
  int substeps = 0;                        // > 0
  Eigen::Vector3d gravity{0.0, 0.0, 0.0};  // m/s^2
  std::span<const double> inverse_mass;    // 1/kg, by vertex; 0 is never moved
  const SharedInertia* shared = nullptr;   // null: no vertices share inertia
};

// Keeps folds and pieces of one sheet from passing through each other, in phases between the substeps of a step.
//
// Response: pairs of features that approach get inelastic impulses with Coulomb friction. After the coming interval
// they are then a thickness apart. Impulses are accumulated and clipped as totals (Bridson, Fedkiw, Anderson 2002).
//
// Check: each phase looks at what every near pair did since the phase before. A plane that separates both sides at both
// ends, or additive continuous collision detection, shows that the pair did not pass. Other pairs are put right along
// their normal, by mass. Those that still fail move as one for that interval. The check keeps folds apart, whatever the
// response does.
//
// Nothing is kept from one step to the next.
class SelfContact {
 public:
  // Must be called after each change of the topology. Allocates memory.
  void set(const mesh::TriangleMesh& mesh);
  // m, >= 0: distance that the middle surfaces keep.
  void set_thickness(double thickness) { thickness_ = thickness; }
  void set_friction(double friction) { friction_ = friction; }  // -, >= 0
  // Bodies that vertices in contact rest on; null: none. It must have begun the same step.
  void set_bodies(const ContactSolver* bodies) { bodies_ = bodies; }

  // Begins a step at positions `x` (3 x V, m) and velocities `v` (m/s), before its first drift. Changes velocities.
  void begin(const SelfContactStep& step, const linear::VertexField& x, linear::VertexField& v);
  // Number of the substep after which the next phase is due; the last phase of a step is due after its last substep.
  [[nodiscard]] int next_phase() const { return next_phase_; }
  // Makes the phase that is due. Changes positions and velocities of the vertices in moved().
  void make_phase(linear::VertexField& x, linear::VertexField& v);
  // Ends a step whose velocities v (m/s) at its end, x (m), are not those of its drifts. Pairs that touch do not close
  // in after it.
  void end(const linear::VertexField& x, linear::VertexField& v);
  // Vertices that the last phase changed.
  [[nodiscard]] std::span<const mesh::VertexId> moved() const { return moved_; }

  // See FeatureTree::find_apart(); between steps.
  void find_apart(double reach, const linear::VertexField& x, std::vector<std::uint8_t>& is_apart) {
    tree_.find_apart(x, reach, is_apart);
  }
  // Returns the number of pairs of triangles that pass through each other at positions x (m), at the end of a step. It
  // is known to be 0 if it was so before the step and no pair of features came near.
  [[nodiscard]] std::int64_t count_intersections(const linear::VertexField& x);
  [[nodiscard]] const SelfContactCounters& counters() const { return counters_; }

 private:
  // A pair that takes part in the response of a phase.
  struct Contact {
    std::size_t pair = 0;
    Separation separation;
    double mass = 0.0;    // kg, effective
    double target = 0.0;  // m/s, least speed along the normal of the soft response
    double limit = 0.0;   // m/s, the same of the hard one
    bool is_in_cones = false;
    Eigen::Vector3d bias{0.0, 0.0, 0.0};      // m/s, from the start to the middle of the interval, see set_biases()
    double impulse = 0.0;                     // N s, along the normal
    Eigen::Vector3d friction{0.0, 0.0, 0.0};  // N s
  };
  // Pairs that may touch, those of vertices and triangles first, and what is known of them.
  struct PairList {
    std::vector<FeaturePair> pairs;
    std::array<std::vector<std::int32_t>, 4> vertices;  // of pairs, and kLanePadding more
    std::vector<float> least;                           // m, as of the pair
    std::vector<float> speed;                           // m/s, as of the pair; kLanePadding more
    std::vector<float> limit;            // m: way_of() up to which it need not be looked at; kLanePadding more
    std::vector<float> safe;             // m: way_of() up to which it cannot have passed; kLanePadding more
    std::vector<std::int64_t> seen;      // the phase in which it was looked at last
    std::vector<Separation> separation;  // then
    std::size_t num_vertex_pairs = 0;

    [[nodiscard]] std::size_t size() const { return pairs.size(); }
    void clear();
    // Adds a pair that nothing is known of.
    void add(const FeaturePair& pair);
    // Adds pairs [begin, end) of another list.
    void add(const PairList& from, std::size_t begin, std::size_t end);
    // Must be called after the last add().
    void pad();
  };
  // A vertex of such a pair on a body.
  struct Support {
    mesh::VertexId vertex = mesh::kNone;
    Eigen::Vector3d normal{0.0, 0.0, 1.0};
    double friction = 0.0;                            // -, coefficient
    double mass = 0.0;                                // kg, effective along the normal
    double target = 0.0;                              // m/s
    Eigen::Vector3d bias{0.0, 0.0, 0.0};              // m/s, from the start to the middle of the interval
    double impulse = 0.0;                             // N s, along the normal
    Eigen::Vector3d friction_impulse{0.0, 0.0, 0.0};  // N s
  };

  [[nodiscard]] PairWays pair_ways() const { return {path_, list_.speed, elapsed_}; }
  // Returns how far both sides of pair p may have moved against each other since the list was made, m.
  [[nodiscard]] float way_of(std::size_t p) const;
  void mark(mesh::VertexId v);
  // Returns the velocity (m/s) of a vertex without what it does against its neighbours. Vertices that vibrate stay near
  // such a line for longer.
  [[nodiscard]] Eigen::Vector3d smooth_velocity(const linear::VertexField& v, mesh::VertexId at) const;
  // Adds the motion since the last phase to path_ and elapsed_.
  void follow_paths(const linear::VertexField& x);
  // Leaves out the pairs that were found and are open.
  void drop_open();
  // Replaces the list by the pairs that were found.
  void set_list();
  // Makes the list again if it is used up, or the part of it that has to do with vertices that strayed.
  void renew_list(const linear::VertexField& x, const linear::VertexField& v, int substep);
  // Returns true if few enough vertices strayed for the list to be renewed in part.
  [[nodiscard]] bool may_follow() const;
  // Gives them new lines, relative to the motion that all vertices share: `since` (s) after the list was made they are
  // at x and move with v, or with smooth_velocity().
  void follow_strayed(const linear::VertexField& x, const linear::VertexField& v, double since, bool is_smoothed);
  // Sets least_slack_ from slack_.
  void set_least_slack();
  // Widens the slack of vertices that strayed from the last list.
  void adapt_slack(const linear::VertexField& x);
  // Looks for pairs from positions x on.
  void search(const linear::VertexField& x, const linear::VertexField& v, int substep);
  // Returns true if no pair can come near before the end of the list. Slacks are then as wide as they may be.
  bool find_list_apart(const linear::VertexField& x);
  // Finds the pairs of strayed vertices for the motion that has happened, which was straight since the last phase.
  void find_again(const linear::VertexField& x);
  // Finds the vertices that are, or will be after `ahead` (s), farther from their lines than `share` of their slack.
  void find_strayed(const linear::VertexField& x, const linear::VertexField& v, double ahead, double share);
  // Finds those of the vertices in shifted_ that are farther from their lines than their slack. find_strayed() must
  // have been called in this phase with the same lines, or follow_strayed().
  void find_strayed_of_shifted(const linear::VertexField& x);
  // Calls look(pairs of one kind in due_, place of the first) for both kinds.
  template <typename Look>
  void for_due_kinds(const Look& look) const;
  // Finds the pairs that can have come near since they were last looked at, and looks at them.
  void look_at_due_pairs(const linear::VertexField& x, const linear::VertexField& v);
  // Returns the separation of a pair after the last phase.
  [[nodiscard]] Separation separation_then(std::size_t pair) const;
  // Checks all pairs and repairs those that fail.
  void check(linear::VertexField& x, linear::VertexField& v);
  // Fills failed_ with the pairs that passed; in later rounds only vertices that were moved since then are looked at.
  [[nodiscard]] bool find_failed(const linear::VertexField& x, bool is_first);
  void move(mesh::VertexId v, const Eigen::Vector3d& to, linear::VertexField& x);
  void repair(std::size_t pair, linear::VertexField& x, linear::VertexField& v);
  // Moves the vertices of a pair by their own masses, or all that share inertia with them.
  void move_apart(const FeaturePair& pair, const Separation& then, double gap, linear::VertexField& x);
  void move_apart_shared(const FeaturePair& pair, const Separation& then, double gap, linear::VertexField& x);
  // Adds a vertex, and those that share inertia with it, to the zone of another.
  void add_to_zone(mesh::VertexId v, mesh::VertexId of);
  void move_zones(linear::VertexField& x, linear::VertexField& v);
  std::int32_t root(mesh::VertexId v);
  // Responds at positions x, for an interval that ends with the next phase, which it chooses.
  void respond(const linear::VertexField& x, linear::VertexField& v, int substep);
  void find_contacts(const linear::VertexField& x, const linear::VertexField& v, int substep);
  // `kicked`: s, part of the interval by whose kicks vertices are faster in its middle.
  void find_supports(const linear::VertexField& x, double duration, double kicked);
  // Sets Contact::bias: vertices fall until the middle of the interval, unless they are held or lie on a body. Measured
  // accelerations would add energy where vertices vibrate.
  void set_biases(double kicked);
  void respond_softly(linear::VertexField& v);
  void respond_softly(std::size_t contact, linear::VertexField& v);
  void support(Support& support, linear::VertexField& v);
  bool respond_hard(std::size_t contact, linear::VertexField& v);
  void apply(const FeaturePair& pair, const Separation& separation, const Eigen::Vector3d& impulse,
             linear::VertexField& v);

  FeatureTree tree_;
  double thickness_ = 0.0;
  double friction_ = 0.3;
  double base_slack_ = 0.0;         // m
  std::vector<float> base_slacks_;  // m, by vertex, at first
  const ContactSolver* bodies_ = nullptr;
  SelfContactStep step_;
  ImpulseResponse response_;
  int substep_ = 0;  // of the last phase
  int next_phase_ = 0;
  int list_end_ = 0;  // substep up to which the list is good
  int list_begin_ = 0;
  int interval_ = 0;        // substeps between the last two phases
  std::int64_t phase_ = 0;  // number of the phase
  bool is_apart_ = false;   // nothing passed through anything before the step, and no pair was near since
  PairList list_, renewed_;
  PairIndex list_index_;  // of list_, if is_indexed_
  bool is_indexed_ = false;
  std::vector<std::int32_t> due_, unseparated_;
  std::vector<float> path_;           // m, by vertex: way since the list was made, relative to its line
  float elapsed_ = 0.0F;              // s, since the list was made
  std::vector<float> due_ways_;       // m, by place in due_
  std::vector<float> due_distances_;  // m, by place in due_, see look_at()
  std::vector<float> due_closing_;    // m/s, by place in due_
  FloatPositions x_float_, x_then_float_;
  bool is_float_set_ = false;  // x_float_ has the positions of the phase, or after it those of the last one
  FloatLanes v_float_;
  std::vector<FeaturePair> found_;
  std::vector<mesh::VertexId> strayed_;
  std::vector<std::uint8_t> is_strayed_;  // by vertex
  std::vector<float> slack_;              // m, by vertex: distance that it may stray from its line
  double least_slack_ = 0.0;              // m
  std::vector<float> wide_slack_;         // m, scratch
  bool is_list_apart_ = false;            // by find_list_apart(), when the list was made
  std::vector<Contact> contacts_;
  std::vector<Support> supports_;
  std::vector<std::size_t> failed_;
  std::vector<mesh::VertexId> shifted_;   // in the last round of repairs
  std::vector<std::uint8_t> is_shifted_;  // by vertex
  linear::VertexField x_then_, v_then_;   // after the last phase
  linear::VertexField x_list_, v_list_;   // when the list was made
  linear::VertexField way_;               // m/s, scratch
  linear::VertexField stray_;             // m, from the lines
  Eigen::Vector3d stray_mean_{0.0, 0.0, 0.0};
  std::vector<mesh::VertexId> moved_;
  std::vector<std::uint8_t> is_moved_;
  std::vector<std::int32_t> zone_;  // by vertex: parent in a forest; itself if it is in no zone
  // The sum of what the vertices of a zone do, weighted by mass.
  struct Zone {
    double mass = 0.0;  // kg
    Eigen::Vector3d way{0.0, 0.0, 0.0}, velocity{0.0, 0.0, 0.0};
  };
  std::vector<mesh::VertexId> zoned_;
  std::vector<std::uint8_t> is_zoned_;
  std::vector<Zone> zones_;  // by vertex: that of the root; else not used
  std::vector<std::uint8_t> is_supported_;
  Untangling untangling_;
  SelfContactCounters counters_;
};

template <typename Look>
void SelfContact::for_due_kinds(const Look& look) const {
  const auto first_edge = static_cast<std::size_t>(
      std::lower_bound(due_.begin(), due_.end(), static_cast<std::int32_t>(list_.num_vertex_pairs)) - due_.begin());
  const std::span<const std::int32_t> due(due_);
  look(PairSelection{FeaturePair::Kind::kVertexTriangle, list_.vertices, due.first(first_edge)}, std::size_t{0});
  look(PairSelection{FeaturePair::Kind::kEdgeEdge, list_.vertices, due.subspan(first_edge)}, first_edge);
}

}  // namespace kerf::contact
