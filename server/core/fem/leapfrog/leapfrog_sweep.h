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

// What is the same in all substeps of a step.
struct LeapfrogTerms {
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();  // m/s^2
  std::span<const double> damping;                    // s, Kelvin-Voigt, of the membrane, one a material
  double bending_damping = 0.0;                       // s
  double h = 0.0;                                     // s
};

// One kick and the drift after it.
struct LeapfrogKick {
  double duration = 0.0;                      // s
  double drift = 0.0;                         // s
  double bending = 0.0;                       // s, duration of the kick by bending forces; 0: none
  const mesh::VertexField* forces = nullptr;  // N, 3 x V, others than those of membrane and bending rows; may be null
};

// C11, C22, C33, C12, N/m: in material axes the others are 0.
inline std::array<double, 4> law_entries(const MaterialLaw& law) {
  const Eigen::Matrix3d& C = law.membrane;
  return {C(0, 0), C(1, 1), C(2, 2), C(0, 1)};
}

// Positions, velocities and the constants of a model in the arrays that leapfrog_kernels.h works on.
// T = float: arithmetic and velocities are floats. Positions are 32-bit integers, multiples of a power of two of a
// metre from the middle of the sheet, or of each piece where pieces are far apart, so that edges are exact to that unit
// wherever the sheet is, with a float remainder so that motion slower than a unit a substep is not lost; velocities
// have one too (Kahan 1965), or thousands of short substeps would round what gravity adds to all of them the same way.
template <typename T>
class LeapfrogSweep {
 public:
  // Clusters of `inertia` move by its inertia.
  void rebuild(const Model& model, const MembraneLayout& layout, const LocalInertia& inertia);
  // After layout.follow(), where that did not rebuild, and inertia.follow().
  void follow(const Model& model, const MembraneLayout& layout, const LocalInertia& inertia);
  // Room for a rebuild() that does not allocate, where `like` is up to date with the model.
  template <typename U>
  void reserve(const Model& model, const MembraneLayout& layout, const LeapfrogSweep<U>& like);

  // Makes positions of steps to come displacements since a step began, and strains those of then and what is added to
  // them: of floats, and of a sheet that hardly moves, this rounds far less. `speed`: m/s, > 0, for which units have
  // room; 0: positions as ever. Of the co-rotational law.
  void step_by_displacements(double speed) { displacement_speed_ = speed; }
  // Takes over the state for a step of this length. False: this precision cannot hold it, or has no displacements of a
  // sheet that is strained so much.
  bool begin(const Model& model, const Loads& loads, const LeapfrogTerms& terms, double duration, const State& state);
  // -, largest principal strain, at least 0, one substep before the state that begin() took over; 0 of
  // Green's.
  [[nodiscard]] double tension() const { return tension_; }
  void substep(const Model& model, const LeapfrogTerms& terms, const LeapfrogKick& kick);
  // Whether no vertex can have left what positions can hold in a step of this length.
  [[nodiscard]] bool stayed_inside(double duration) const;
  // Whether floats can hold the model's sheet at all: lying still, as a square of its size.
  [[nodiscard]] static bool may_hold(const Model& model);
  // 1/m, of the flattest triangles that T is used for.
  [[nodiscard]] static double flattest(const Model& model);

  // Moves vertices out of bodies after a substep that drifted for `drift`, s. Clusters move as a whole, by their
  // inertia. The next substep moves what that leaves inside. Looks at blocks that may touch alone. False: see read().
  bool enforce(ContactConstraint& contact, double drift);
  // The same of the last substep: what may touch is found after the drift, and moved after the kick that closes the
  // step, so that what leaves the step respects the bodies.
  void find_touching(ContactConstraint& contact, double drift);
  bool enforce_found(ContactConstraint& contact);
  // Returns whether a body has moved a vertex since begin().
  [[nodiscard]] bool touched() const { return touched_; }
  // Times that bodies pushed a cluster since begin().
  [[nodiscard]] int num_cluster_pushes() const { return num_cluster_pushes_; }

  // Of what has mass or is held. False: outside of what positions can hold.
  bool read(const State& state);
  void write(State& state) const;
  // m, m/s.
  [[nodiscard]] Eigen::Vector3d position(mesh::VertexId v) const;
  [[nodiscard]] Eigen::Vector3d velocity(mesh::VertexId v) const;
  // A point sum_k weights[k] x(vertices[k]) of a grab. 1/kg by component, what an impulse there moves it by; 0 where it
  // is held.
  [[nodiscard]] Eigen::Array3d mobility(const Grab& grab);
  // Gives it an impulse, N s, and moves what that moves for `drift`, s. False: see read().
  bool push(const Grab& grab, const Eigen::Array3d& impulse, double drift);

 private:
  template <typename U>
  friend class LeapfrogSweep;
  using Position = PositionOf<T>;
  template <typename U>
  using Field = std::array<std::vector<Lanes16<U>>, 3>;
  // Positions of floats reach this far from their origin, in units, so that differences still fit into 32 bits.
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
    [[nodiscard]] double size() const { return (high - low).maxCoeff(); }  // m; negative where nothing was added
    [[nodiscard]] Eigen::Vector3d middle() const { return 0.5 * (low + high).matrix(); }
  };
  // A change that a body wants of a vertex in a cluster.
  struct Push {
    mesh::VertexId vertex = mesh::kNone;
    std::int32_t next = mesh::kNone;  // of the same cluster
    std::array<T, 3> velocity{};      // m/s, change
    std::array<T, 3> position{};      // m, change
  };
  // Scratch of enforce().
  struct Contact {
    mesh::VertexLanes vertices, given;
    double drift = 0.0;  // s, of the substep of find_touching()
    // The blocks that find_touching() found, and positions of their vertices before; longer than there are.
    std::size_t num_blocks = 0;
    std::vector<std::int32_t> blocks;
    std::vector<std::array<mesh::VertexLanes::Lanes, 3>> before;
    std::vector<Push> pushes;
    std::vector<std::int32_t> first_push;  // by slots of clusters; kNone: not pushed
    std::vector<std::int32_t> slots;       // of clusters that are pushed
    ClusterPush<T> push;
    double moved = 0.0;  // m, the most that a vertex is off where its body saw it last

    void reserve(const LocalInertia& inertia) {
      push.reserve(inertia.largest());
      if (first_push.size() < inertia.num_slots()) first_push.resize(inertia.num_slots(), mesh::kNone);
      slots.reserve(first_push.capacity());
      if (pushes.capacity() >= inertia.num_vertices()) return;
      pushes.reserve(inertia.num_vertices() + inertia.num_vertices() / 4);
    }
  };

  template <typename Set>
  void for_arrays(const Model& model, const MembraneLayout& layout, const Set& set);  // set(array, size)
  void resize(const Model& model, const MembraneLayout& layout);
  [[nodiscard]] double coarsest_gradient(const Model& model);
  // Sets the arrays of the lanes that are fine by now.
  void set_fine_constants(const Model& model, const MembraneLayout& layout);
  void set_fine_positions();
  [[nodiscard]] LeapfrogStep<double> fine_step(const Model& model, const LeapfrogTerms& terms) const;
  void set_quads(const Model& model, const MembraneLayout& layout, mesh::VertexId v);
  void set_lane(const Model& model, const MembraneLayout& layout, std::size_t lane);
  void set_mobility(const Model& model, const Loads& loads);
  // Chooses where positions count from, and their unit. False: see begin().
  bool set_frame(const Model& model, const LeapfrogTerms& terms, double duration, const State& state);
  // The same for each piece by itself. Returns how far positions may come from there, m.
  double set_frames_of_pieces(const LeapfrogTerms& terms, double duration, const State& state);
  void find_pieces();
  [[nodiscard]] bool is_by_displacements() const { return displacement_speed_ > 0.0; }
  [[nodiscard]] bool has_starts() const { return is_by_displacements() || is_by_pieces_; }
  // Sets what displacements are added to. False: see begin().
  bool set_start(const Model& model, const State& state);
  // m, of the place that the position of a vertex counts from.
  [[nodiscard]] Eigen::Vector3d base(mesh::VertexId v) const {
    return has_starts() ? Eigen::Vector3d(start_.col(v)) : origin_;
  }
  // Into extra_: those of a kick, and of bending what does not depend on displacements. False: none.
  bool set_extra_forces(const Model& model, const LeapfrogKick& kick);
  // Those of triangles and edges in the unit of positions: exact, as units are powers of two.
  void set_unit_of_constants();
  void set_laws(const Model& model, const LeapfrogTerms& terms);
  void follow_bending(const Model& model);
  // Puts what vertices of clusters are accelerated by beside gravity, m/s^2, in the place of the forces on them.
  // forces: N, of the kick, which are among them, or null.
  void accelerate_clusters(const Model& model, const LeapfrogStep<T>& step, const mesh::VertexField* forces);
  // Into cluster_values_: what an impulse of 1 N s at the part of the grab's point that is in this cluster moves.
  void set_response(const Grab& grab, const InertiaCluster& cluster);
  // at_vertex(v, weight) of those outside of clusters, at_cluster(cluster), with its response, of each cluster once.
  template <typename AtVertex, typename AtCluster>
  void for_each_grabbed(const Grab& grab, const AtVertex& at_vertex, const AtCluster& at_cluster);
  // m, no vertex moved farther in the last substep.
  [[nodiscard]] double farthest_moved(double drift) const;
  bool enforce_block(ContactConstraint& contact, const LeapfrogArrays<T>& arrays, std::int32_t block);
  void gather_pushes(std::size_t block, std::uint32_t changed);
  // Moves clusters of which bodies push vertices, after a substep that drifted for `drift`, s.
  bool push_clusters(double drift);
  // Moves each vertex by its change, x 4, times the factor, m. Adds how far the farthest goes to `travel`, m.
  bool move_cluster(std::span<const mesh::VertexId> vertices, const T* change, double factor, double& travel);
  // Sets a change of each vertex of a cluster that a body wants, by `change` of a push, and 0 of the others.
  void set_wanted(std::int32_t slot, std::array<T, 3> Push::*change);
  // Moves what push_clusters() left inside, vertex by vertex.
  bool enforce_rest(ContactConstraint& contact);
  void add_velocity(std::size_t v, std::size_t component, T change);  // m/s
  bool add_position(std::size_t v, const Eigen::Vector3d& change);    // m; false: see read()
  [[nodiscard]] PositionFrame frame() const {
    return {{origin_.x(), origin_.y(), origin_.z()}, has_starts() ? start_.data() : nullptr, unit_};
  }
  // m, that rounding may take a vertex farther than its velocity does in a substep.
  [[nodiscard]] double unit_of_rounding() const { return std::is_same_v<T, float> ? unit_ : 0.0; }
  bool set_position(mesh::VertexId v, const Eigen::Vector3d& position);
  void set_velocity(mesh::VertexId v, const Eigen::Vector3d& velocity);
  [[nodiscard]] LeapfrogStep<T> step_of(const Model& model, const LeapfrogTerms& terms) const;
  [[nodiscard]] LeapfrogArrays<T> arrays();

  const MembraneLayout* layout_ = nullptr;
  const LocalInertia* inertia_ = nullptr;
  Field<Position> x_;
  Field<T> v_, remainder_, v_remainder_, mobility_;
  std::vector<Lanes16<T>> mass_damping_;                 // of several
  std::vector<LawLanes<T>> quad_laws_, irregular_laws_;  // of several materials
  std::vector<std::uint8_t> takes_part_;                 // has mass, or is held
  std::vector<TriangleLanes<T>> quads_;
  std::vector<EdgeLanes<T>> quad_edges_, irregular_edges_;  // of Green's strain
  std::vector<StrainLanes<T>> quads_before_;                // as quads_ or quad_edges_
  std::vector<IrregularBlock<T>> irregular_;
  std::size_t pad_ = 0;  // blocks that offsets reach; three times that are before the first vertex in x_
  std::array<Field<T>, 4> quad_force_;
  std::vector<Lanes16<Position>> corner_x_, bending_fours_;
  Field<Position> bending_x_;  // a block before the first vertex, and one behind the last
  std::vector<Lanes16<T>> corner_force_, gathered_, extra_;
  BendingLayout<T> bending_;
  IdSet bending_blocks_;                     // scratch
  FineTriangles fine_;                       // of floats
  std::optional<double> coarsest_gradient_;  // 1/m, of the other triangles; absent: to be found
  IndexSet fine_vertices_;                   // scratch
  std::vector<std::uint8_t> has_cluster_;    // of each block of vertices; empty without clusters
  std::vector<Lanes16<T>> cluster_values_;   // x 4, of one cluster, scratch
  Contact contact_;
  bool touched_ = false;
  int num_cluster_pushes_ = 0;
  double displacement_speed_ = 0.0;  // m/s, see step_by_displacements()
  std::vector<StartLanes<T>> quad_start_, irregular_start_;
  bool is_by_pieces_ = false;                         // each piece counts from a place of its own in this step
  std::vector<mesh::VertexId> piece_of_;              // lowest vertex of its piece; empty: to be found
  std::vector<Extent> extents_;                       // scratch, of pieces by their lowest vertices
  mesh::VertexField start_;                           // m, of all lanes, where positions count from by has_starts()
  mesh::VertexField bending_start_;                   // N, 3 x V, forces of bending then
  Lanes16<T> speed_;                                  // m/s, largest components of velocities in the last substep
  T fastest_ = 0;                                     // m/s, the same of the substeps before
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();  // m
  double unit_ = 1.0;                                 // m
  double unit_of_constants_ = 1.0;                    // m
  double room_ = 0.0;                                 // m, that the sheet can travel
  double tension_ = 0.0;                              // -
};

}  // namespace kerf::fem
