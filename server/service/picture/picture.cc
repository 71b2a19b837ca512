#include "server/service/picture/picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include "render/colours.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/scene/sheet_materials.h"
#include "server/service/picture/material_look.h"
#include "server/service/picture/picture_colours.h"
#include "server/service/picture/scene_look.h"

namespace kerf::picture {
namespace {

render::Vec3 to_vec3(const Eigen::Vector3d& vector) {
  return {vector.x(), vector.y(), vector.z()};
}

struct ShapeForRenderer {
  render::Collider operator()(const contact::Plane& plane) const {
    return render::Plane{to_vec3(plane.point), to_vec3(plane.normal)};
  }
  render::Collider operator()(const contact::Sphere& sphere) const {
    return render::Sphere{to_vec3(sphere.centre), sphere.radius};
  }
  render::Collider operator()(const contact::OrientedBox& box) const {
    render::Box drawn{to_vec3(box.centre), to_vec3(box.half_extents), {1.0, 0.0, 0.0, 0.0}};
    const double length = box.axis.norm();
    if (length > 0.0) {
      const Eigen::Vector3d axis = box.axis / length;
      const double sine = std::sin(0.5 * box.angle);
      drawn.rotation = {std::cos(0.5 * box.angle), sine * axis.x(), sine * axis.y(), sine * axis.z()};
    }
    return drawn;
  }
  render::Collider operator()(const contact::Capsule& capsule) const {
    return render::Capsule{to_vec3(capsule.a), to_vec3(capsule.b), capsule.radius};
  }
};

// Owns the arrays that render::Mesh views.
struct MeshArrays {
  std::vector<float> positions;
  std::vector<float> material;
  std::vector<std::int32_t> triangles;
  std::vector<std::int32_t> pieces;
  std::vector<std::int32_t> looks;    // Empty: one look.
  std::vector<std::uint8_t> colours;  // Empty: the colours of the sheet's two sides.
};

// Places material points in the plane z = 0.
Eigen::Matrix3Xd laid_out(const Eigen::Matrix2Xd& material) {
  Eigen::Matrix3Xd positions = Eigen::Matrix3Xd::Zero(3, material.cols());
  positions.topRows<2>() = material;
  return positions;
}

MeshArrays arrays_of(const sheet::Snapshot& snapshot, const Eigen::Matrix3Xd& positions) {
  const sheet::Topology& topology = *snapshot.topology;
  MeshArrays arrays;
  const auto append = [](const auto& matrix, std::vector<float>& out) {
    out.reserve(static_cast<std::size_t>(matrix.size()));
    for (Eigen::Index i = 0; i < matrix.size(); ++i) out.push_back(static_cast<float>(matrix.data()[i]));
  };
  append(positions, arrays.positions);
  append(topology.material_positions, arrays.material);
  const bool has_looks = snapshot.materials && snapshot.materials->by_region.size() > 1;
  for (std::size_t slot = 0; slot < topology.triangles.size(); ++slot) {
    if (topology.pieces[slot] == mesh::kNone) continue;
    arrays.triangles.insert(arrays.triangles.end(), topology.triangles[slot].begin(), topology.triangles[slot].end());
    arrays.pieces.push_back(topology.pieces[slot]);
    if (has_looks) arrays.looks.push_back(topology.regions[slot]);
  }
  return arrays;
}

// Returns the looks of the materials, by region of the mesh.
std::vector<render::Look> looks_of(const sheet::Snapshot& snapshot) {
  std::vector<render::Look> looks;
  for (const fem::Material& each : snapshot.materials->by_region) {
    looks.push_back(look_of({std::max(each.youngs_modulus_1, each.youngs_modulus_2), each.thickness, each.density}));
  }
  return looks;
}

render::Style style_of(const PictureView& view, const sheet::Snapshot& snapshot) {
  render::Style style;
  if (snapshot.materials) style.looks = looks_of(snapshot);
  style.wireframe = view.wireframe;
  set_surroundings(view.dark, style);
  if (view.undeformed) {
    style.shadows = false;            // A flat sheet casts none on itself.
    style.light.towards_key.reset();  // Seen from above, with y up.
  }
  if (view.undeformed && view.wireframe) {  // Shows the triangles alone.
    style.texture = false;
    for (render::Look& look : style.looks) look.front = {0.66, 0.76, 0.86};
  }
  return style;
}

render::Camera whole_sheet(std::span<const float> positions, const PictureView& view) {
  const double aspect = static_cast<double>(view.width) / view.height;
  if (!view.undeformed) return render::fit_camera(positions, aspect);
  return render::fit_camera(positions, aspect, {0.0, 0.0, 1.0}, {0.0, 1.0, 0.0});
}

// Reports a sheet out of reach. The request is valid: a sheet that is not held falls without end.
Error out_of_reach(const Eigen::Matrix3Xd& positions) {
  std::array<char, 160> text{};
  std::snprintf(
      text.data(), text.size(),
      "the sheet reaches to %.3g m from the origin; pictures are drawn within %.3g m of it: reset the sheet, and "
      "pin it or put something under it",
      positions.cwiseAbs().maxCoeff(), render::kMaxCoordinate);
  return failed_precondition("SHEET_OUT_OF_REACH", text.data());
}

// Returns positions in the world, or laid out flat.
Eigen::Matrix3Xd positions_of(const sheet::Snapshot& snapshot, const PictureView& view) {
  return view.undeformed ? laid_out(snapshot.topology->material_positions) : snapshot.positions;
}

void colour(const sheet::Snapshot& snapshot, const PictureView& view, double strain_end, MeshArrays& arrays) {
  if (view.color_by == v1::PIECES) arrays.colours = piece_colours(*snapshot.topology);
  if (view.color_by == v1::STRAINS) {
    arrays.colours = render::strain_colours(snapshot.strains, strain_end);
    arrays.colours.resize(arrays.positions.size());  // Missing strains, requested too late, are dark.
  }
}

// Returns a scene that views `arrays`.
render::Scene scene_of(const MeshArrays& arrays, const PictureSubject& subject, const PictureView& view) {
  const Backdrop& backdrop = subject.backdrop;
  render::Scene scene;
  scene.mesh.positions = arrays.positions;
  scene.mesh.material_coordinates = arrays.material;
  scene.mesh.triangles = arrays.triangles;
  // The viewer's mesh has no tints; on a flat sheet they tell pieces apart whose cuts are closed.
  if (view.undeformed) scene.mesh.piece_ids = arrays.pieces;
  scene.mesh.looks = arrays.looks;
  scene.mesh.vertex_colours = arrays.colours;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    scene.mesh.material_lower[axis] = static_cast<float>(backdrop.material_box.min()[i]);
    scene.mesh.material_upper[axis] = static_cast<float>(backdrop.material_box.max()[i]);
  }
  if (!view.undeformed) {
    for (const contact::Collider& collider : backdrop.config->colliders) {
      scene.colliders.push_back(std::visit(ShapeForRenderer{}, collider.shape));
    }
  }
  scene.style = style_of(view, *subject.snapshot);
  return scene;
}

}  // namespace

Backdrop backdrop_of(const sheet::Sheet& sheet) {
  return {sheet.shared_config(), sheet.mesh().bounding_box()};
}

Result<DrawnPicture> draw_picture(render::Renderer& renderer, const PictureSubject& subject, const PictureView& view,
                                  double strain_end) {
  const sheet::Snapshot& snapshot = *subject.snapshot;
  const Eigen::Matrix3Xd positions = positions_of(snapshot, view);
  if (!(positions.array().abs() <= render::kMaxCoordinate).all()) return out_of_reach(positions);
  DrawnPicture picture;
  if (view.color_by == v1::STRAINS) picture.strain_end = render::strain_scale_end(snapshot.strains, strain_end);
  MeshArrays arrays = arrays_of(snapshot, positions);
  colour(snapshot, view, picture.strain_end, arrays);
  const render::Scene scene = scene_of(arrays, subject, view);
  picture.camera = view.camera ? *view.camera : whole_sheet(scene.mesh.positions, view);
  if (!view.camera && !render::validate(picture.camera).ok()) return out_of_reach(positions);
  const render::Status status = renderer.render(scene, picture.camera, view.width, view.height, picture.pixels);
  if (!status.ok()) return to_error(status);
  return picture;
}

Result<std::string> encode_still(const render::Pixels& pixels, const StillFormat& format) {
  std::vector<std::uint8_t> bytes;
  const render::Status status =
      format.jpeg ? render::encode_jpeg(pixels, format.quality, bytes) : render::encode_png(pixels, bytes);
  if (!status.ok()) return to_error(status);
  return std::string(bytes.begin(), bytes.end());
}

}  // namespace kerf::picture
