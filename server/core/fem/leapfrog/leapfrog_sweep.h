#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

#include <Eigen/Core>

#include "server/core/fem/element/contact_constraint.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/material_table.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/leapfrog/cluster_push.h"
#include "server/core/fem/leapfrog/fine_triangles.h"
#include "server/core/fem/leapfrog/leapfrog_kernels.h"
#include "server/core/fem/leapfrog/leapfrog_vertex_lanes.h"
#include "server/core/fem/leapfrog/membrane_layout.h"
#include "server/core/fem/model/local_inertia.h"
#include "server/core/fem/model/model.h"
#include "server/core/linear/index_set.h"
#include "server/core/linear/row_store.h"

namespace kerf::fem {

// Terms that are the same in all substeps of a step.
struct LeapfrogTerms {
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();  // m/s^2
  std::span<const double> damping;                    // s, Kelvin-Voigt damping time of the membrane, by material
  double bending_damping = 0.0;                       // s
  double h = 0.0;                                     // s
};

// One kick and the drift after it.
struct LeapfrogKick {
  double duration = 0.0;                        // s
  double drift = 0.0;                           // s
  double bending = 0.0;                         // s, duration of the kick by bending forces, which act once in several
                                                // substeps; 0: not in this one
  const linear::VertexField* forces = nullptr;  // N, 3 x V, all forces except those of membrane, bending matrix,
                                                // gravity and grabs; may be null
};

// Returns C11, C22, C33, C12, N/m, of the membrane law. The other entries are 0 in material axes.
inline std::array<double, 4> law_entries(const MaterialLaw& law) {
  const Eigen::Matrix3d& C = law.membrane;
  return {C(0, 0), C(1, 1), C(2, 2), C(0, 1)};
}

// Positions, velocities and the constants of a model in the arrays of leapfrog_kernels.h. With T = float, arithmetic
// and velocities are floats, and positions are 32-bit integers. Their unit is a power of two of a metre. Their origin
// is the middle of the sheet, or of each piece if pieces are far apart. Edges are thus exact to that unit wherever the
// sheet is. Each position has a float remainder below a unit, so that motion slower than a unit a substep is not lost.
// Each velocity has a remainder, too (Kahan 1965). Without it each of thousands of short substeps would round the
// increment by gravity in the same direction.
template <typename T>
class LeapfrogSweep {
 public:
  // Sets up everything for a model. Clusters of `inertia` move by its inertia.
  void rebuild(const Model& model, const MembraneLayout& layout, const LocalInertia& inertia);
  // Updates after layout.follow() and inertia.follow(). If layout.follow() has rebuilt the layout, rebuild() must be
  // called instead.
  void follow(const Model& model, const MembraneLayout& layout, const LocalInertia& inertia);
  // Reserves memory so that rebuild() does not allocate. `like` must be up to date with the model.
  template <typename U>
  void reserve(const Model& model, const MembraneLayout& layout, const LeapfrogSweep<U>& like);

  // In later steps positions are displacements since the step began, and strains are the initial ones plus their
  // change. With floats, and a sheet that hardly moves, this rounds far less. `speed`: m/s, > 0, up to which
  // displacements stay in range; 0 restores plain positions. Co-rotational law only.
  void step_by_displacements(double speed) { displacement_speed_ = speed; }
  // Loads the state for a step of `duration` (s). Returns false if the precision T cannot hold it, or if the sheet is
  // strained too much for displacements to represent it.
  bool begin(const Model& model, const Loads& loads, const LeapfrogTerms& terms, double duration, const State& state);
  // -, largest principal strain, at least 0, of the sheet one substep before the state that begin() loaded; 0 with
  // Green's strain.
  [[nodiscard]] double tension() const { return tension_; }
  void substep(const Model& model, const LeapfrogTerms& terms, const LeapfrogKick& kick);
  // Returns true if no vertex can have left the range of positions since begin(), in a step of `duration` (s).
  [[nodiscard]] bool stayed_inside(double duration) const;
  // Returns true if mixed precision can probably hold the sheet: it is tested at rest, as a square of the same area.
  [[nodiscard]] static bool may_hold(const Model& model);
  // 1/m, RestElements::gradient() of the flattest triangles that are computed in T; with floats, flatter ones are
  // FineTriangles.
  [[nodiscard]] static double flattest(const Model& model);

  // Moves vertices out of bodies after a substep that drifted for `drift`, s. Clusters move as a whole, by their
  // inertia. Vertices of clusters may remain inside until the next substep. Checks only blocks that may touch a body.
  // Returns false if positions are out of range.
  bool enforce(ContactConstraint& contact, double drift);
  // Do the work of enforce() for the last substep, in two parts. find_touching() finds the contacts after the drift.
  // enforce_found() moves the vertices after the kick that closes the step, so that the final state respects the
  // bodies. It also moves, one by one, vertices that pushed clusters leave inside.
  void find_touching(ContactConstraint& contact, double drift);
  bool enforce_found(ContactConstraint& contact);
  // Returns true if a body has moved a vertex since begin().
  [[nodiscard]] bool touched() const { return touched_; }
  // Number of times that bodies pushed a cluster since begin().
  [[nodiscard]] int num_cluster_pushes() const { return num_cluster_pushes_; }

  // Loads the vertices that have mass or are held. Returns false if positions are out of range.
  bool read(const State& state);
  void write(State& state);
  // Loads some vertices. Returns false if positions are out of range.
  bool set_vertices(std::span<const mesh::VertexId> vertices, const State& state);
  // Position (m) and velocity (m/s) of a vertex.
  [[nodiscard]] Eigen::Vector3d position(mesh::VertexId v) const;
  [[nodiscard]] Eigen::Vector3d velocity(mesh::VertexId v) const;
  // Velocity per impulse (1/kg, by component) at a grab's point sum_k weights[k] x(vertices[k]); 0 in held components.
  [[nodiscard]] Eigen::Array3d mobility(const Grab& grab);
  // Applies an impulse, N s, to the grab's point, and moves the affected vertices for `drift`, s. Returns false if
  // positions are out of range.
  bool push(const Grab& grab, const Eigen::Array3d& impulse, double drift);

 private:
  template <typename U>
  friend class LeapfrogSweep;
  using Position = PositionOf<T>;
  template <typename U>
  using Field = std::array<std::vector<linear::Lanes16<U>>, 3>;
  // Largest fixed-point position, in units. Differences of two still fit into 32 bits.
  static constexpr double kReach = 1 << 30;

  // Bounds of the positions and speeds of some vertices.
  struct Extent {
    Eigen::Array3d low = Eigen::Array3d::Constant(std::numeric_limits<double>::infinity());
    Eigen::Array3d high = Eigen::Array3d::Constant(-std::numeric_limits<double>::infinity());
    double speed = 0.0;  // m/s, largest component

    void add(const State& state, mesh::VertexId v) {
      low = low.min(state.x.col(v).array());
      high = high.max(state.x.col(v).array());
      speed = std::max(speed, state.v.col(v).cwiseAbs().maxCoeff());
    }
    [[nodiscard]] double size() const { return (high - low).maxCoeff(); }  // m; negative if nothing was added
    [[nodiscard]] Eigen::Vector3d middle() const { return 0.5 * (low + high).matrix(); }
  };
  // A change that a body requires of a vertex in a cluster.
  struct Push {
    mesh::VertexId vertex = mesh::kNone;
    std::int32_t next = mesh::kNone;  // next push of the same cluster
    std::array<T, 3> velocity{};      // m/s, change of velocity
    std::array<T, 3> position{};      // m, change of position
  };
  // Scratch of enforce(), find_touching() and enforce_found().
  struct Contact {
    mesh::VertexLanes vertices, given;
    double drift = 0.0;  // s, as passed to find_touching()
    // The first num_blocks entries of `blocks` are the blocks of vertices that find_touching() found near a body. Those
    // of `before` hold the positions of their vertices when the substep began, m. Both arrays have room for all blocks.
    std::size_t num_blocks = 0;
    std::vector<std::int32_t> blocks;
    std::vector<std::array<mesh::VertexLanes::Lanes, 3>> before;
    std::vector<Push> pushes;
    std::vector<std::int32_t> first_push;  // by slot of a cluster: its first push in `pushes`, or kNone
    std::vector<std::int32_t> slots;       // slots of clusters that are pushed
    ClusterPush<T> push;
    double moved = 0.0;  // m, upper bound of the distance between any vertex and its position when contact last checked
                         // it

    void reserve(const LocalInertia& inertia) {
      push.reserve(inertia.largest());
      if (first_push.size() < inertia.num_slots()) first_push.resize(inertia.num_slots(), mesh::kNone);
      slots.reserve(first_push.capacity());
      if (pushes.capacity() >= inertia.num_vertices()) return;
      pushes.reserve(inertia.num_vertices() + inertia.num_vertices() / 4);
    }
  };

  template <typename Set>
  // Calls set(array, size) for each array.
  void for_arrays(const Model& model, const MembraneLayout& layout, const Set& set);
  void resize(const Model& model, const MembraneLayout& layout);
  [[nodiscard]] double coarsest_gradient(const Model& model);
  // Sets the constants of fine_ for the lanes that are fine.
  void set_fine_constants(const Model& model, const MembraneLayout& layout);
  void set_fine_positions();
  [[nodiscard]] LeapfrogStep<double> fine_step(const Model& model, const LeapfrogTerms& terms) const;
  void set_quads(const Model& model, const MembraneLayout& layout, mesh::VertexId v);
  void set_lane(const Model& model, const MembraneLayout& layout, std::size_t lane);
  void set_mobility(const Model& model, const Loads& loads);
  // Chooses the origin and the unit of positions. Returns false if precision T cannot hold the sheet.
  bool set_frame(const Model& model, const LeapfrogTerms& terms, double duration, const State& state);
  // Chooses an origin for each piece. Returns the largest distance, m, that a vertex may have from the origin of its
  // piece during the step.
  double set_frames_of_pieces(const LeapfrogTerms& terms, double duration, const State& state);
  void find_pieces();
  [[nodiscard]] bool is_by_displacements() const { return displacement_speed_ > 0.0; }
  [[nodiscard]] bool has_starts() const { return is_by_displacements() || is_by_pieces_; }
  // Sets the state that displacements are added to. Returns false if the sheet is strained too much for that.
  bool set_start(const Model& model, const State& state);
  // Returns the origin of the position of a vertex, m.
  [[nodiscard]] Eigen::Vector3d base(mesh::VertexId v) const {
    return has_starts() ? Eigen::Vector3d(start_.col(v)) : origin_;
  }
  // Sets extra_ to kick.forces plus, in steps by displacements, the bending forces at the start of the step. Returns
  // false if there are neither.
  bool set_extra_forces(const Model& model, const LeapfrogKick& kick);
  // Converts the constants of triangles and edges to the unit of positions. This is exact, as units are powers of two.
  void set_unit_of_constants();
  void set_laws(const Model& model, const LeapfrogTerms& terms);
  void follow_bending(const Model& model);
  // Replaces the forces on vertices of clusters in gathered_ by their accelerations without gravity, m/s^2. `forces`
  // are those of LeapfrogKick; gathered_ includes them already.
  void accelerate_clusters(const Model& model, const LeapfrogStep<T>& step, const linear::VertexField* forces);
  // Sets cluster_values_ to the change of velocity of a cluster's vertices if an impulse of 1 N s in each component
  // acts on the grab's point. Only the point's weights inside the cluster count.
  void set_response(const Grab& grab, const InertiaCluster& cluster);
  // Calls at_vertex(v, weight) for vertices outside clusters. Calls at_cluster(cluster) once for each cluster, with its
  // response set.
  template <typename AtVertex, typename AtCluster>
  void for_each_grabbed(const Grab& grab, const AtVertex& at_vertex, const AtCluster& at_cluster);
  // Returns an upper bound of the distance, m, that any vertex moved in the last substep.
  [[nodiscard]] double farthest_moved(double drift) const;
  bool enforce_block(ContactConstraint& contact, const LeapfrogArrays<T>& arrays, std::int32_t block);
  void gather_pushes(std::size_t block, std::uint32_t changed);
  // Moves pushed clusters after a substep that drifted for `drift`, s.
  bool push_clusters(double drift);
  // Moves each vertex by its entry of `change` (x 4) times `factor`, m. Adds the largest distance moved to `travel`, m.
  bool move_cluster(std::span<const mesh::VertexId> vertices, const T* change, double factor, double& travel);
  // Sets the input of ClusterPush::respond() for a cluster. For each pushed vertex it is the member `change` of its
  // push, which a body requires; for all others 0.
  void set_wanted(std::int32_t slot, std::array<T, 3> Push::*change);
  // Moves vertices that push_clusters() left inside, one by one.
  bool enforce_rest(ContactConstraint& contact);
  void add_velocity(std::size_t v, std::size_t component, T change);  // m/s
  bool add_position(std::size_t v, const Eigen::Vector3d& change);    // m; returns false if the position is out of
                                                                      // range
  [[nodiscard]] PositionFrame frame() const {
    return {{origin_.x(), origin_.y(), origin_.z()}, has_starts() ? start_.data() : nullptr, unit_};
  }
  // m, largest additional motion of a vertex in a substep that rounding causes.
  [[nodiscard]] double unit_of_rounding() const { return std::is_same_v<T, float> ? unit_ : 0.0; }
  bool set_position(mesh::VertexId v, const Eigen::Vector3d& position);
  void set_velocity(mesh::VertexId v, const Eigen::Vector3d& velocity);
  [[nodiscard]] LeapfrogStep<T> step_of(const Model& model, const LeapfrogTerms& terms) const;
  [[nodiscard]] LeapfrogArrays<T> arrays();

  const MembraneLayout* layout_ = nullptr;
  const LocalInertia* inertia_ = nullptr;
  Field<Position> x_;
  Field<T> v_, remainder_, v_remainder_, mobility_;
  std::vector<linear::Lanes16<T>> mass_damping_;         // for several materials
  std::vector<LawLanes<T>> quad_laws_, irregular_laws_;  // for several materials
  std::vector<std::uint8_t> takes_part_;                 // by vertex: has mass, or is held
  std::vector<TriangleLanes<T>> quads_;
  std::vector<EdgeLanes<T>> quad_edges_, irregular_edges_;  // with Green's strain
  std::vector<StrainLanes<T>> quads_before_;                // as quads_ or quad_edges_
  std::vector<IrregularBlock<T>> irregular_;
  std::size_t pad_ = 0;  // number of blocks that offsets of quads reach; 3 pad_ blocks precede the first vertex in x_
  std::array<Field<T>, 4> quad_force_;
  std::vector<linear::Lanes16<Position>> corner_x_, bending_fours_;
  Field<Position> bending_x_;  // has a block before the first vertex, and one behind the last
  std::vector<linear::Lanes16<T>> corner_force_, gathered_, extra_;
  BendingLayout<T> bending_;
  linear::IdSet bending_blocks_;             // scratch
  FineTriangles fine_;                       // with T = float only
  std::optional<double> coarsest_gradient_;  // 1/m, largest gradient() of the triangles not in fine_; empty until
                                             // computed
  linear::IndexSet fine_vertices_;           // scratch
  std::vector<std::uint8_t> has_cluster_;    // by block of vertices; empty without clusters
  std::vector<linear::Lanes16<T>> cluster_values_;  // x 4, of one cluster, scratch
  Contact contact_;
  bool touched_ = false;
  int num_cluster_pushes_ = 0;
  double displacement_speed_ = 0.0;  // m/s, see step_by_displacements()
  std::vector<StartLanes<T>> quad_start_, irregular_start_;
  bool is_by_pieces_ = false;                         // each piece has its own origin in this step
  std::vector<mesh::VertexId> piece_of_;              // by vertex: the lowest vertex of its piece; empty until computed
  std::vector<Extent> extents_;                       // scratch, of pieces by their lowest vertices
  linear::VertexField start_;                         // m, by vertex, origins of positions if has_starts()
  linear::VertexField bending_start_;                 // N, 3 x V, forces of bending at start_
  linear::Lanes16<T> speed_;                          // m/s, largest velocity components in the last substep
  T fastest_ = 0;                                     // m/s, largest velocity component in all earlier substeps since
                                                      // begin()
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();  // m
  double unit_ = 1.0;                                 // m
  double unit_of_constants_ = 1.0;                    // m
  double room_ = 0.0;                                 // m, distance that a vertex can travel in the step without
                                                      // leaving the range
  double tension_ = 0.0;                              // -
};

}  // namespace kerf::fem
