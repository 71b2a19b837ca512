#pragma once

#include <map>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <pugixml.hpp>

#include "server/base/result.h"
#include "server/core/cut/curve.h"
#include "server/service/svg/attributes.h"
#include "server/service/svg/transform.h"

namespace kerf::svg {

// Visits a document in drawing order and collects the outlines of the shapes shown.
class Walk {
 public:
  // `root`: the outermost svg element. `to_sheet`: maps CSS pixels of its viewport to the path's coordinates.
  Walk(const pugi::xml_node& root, const Affine& to_sheet);

  // Visits the document; to be called once. Errors: SVG_TOO_COMPLEX, and CURVE_TOO_LONG as soon as the limit is passed.
  Status run();

  [[nodiscard]] cut::Path take_path() { return std::move(path_); }
  // Lists the parts that are not cut, as text for users, in alphabetical order.
  [[nodiscard]] std::vector<std::string> not_cut() const;

 private:
  // Holds the state that an element inherits.
  struct Context {
    Affine to_sheet;
    Viewport viewport;
    bool visible = true;
    int depth = 0;  // Nesting of elements, those that replace a `use` included.
  };

  // Returns the name without its prefix; empty if the element is not SVG's.
  [[nodiscard]] std::string_view name_of(const pugi::xml_node& node) const;
  [[nodiscard]] pugi::xml_node target_of(const std::string& reference) const;

  Status index_ids();
  Status count_visit(const pugi::xml_node& node);
  Status visit(const pugi::xml_node& node, const Context& inherited);
  // Visits a visible element whose own transform and properties are already in the context.
  Status visit_shown(const pugi::xml_node& node, std::string_view name, const Context& context);
  Status visit_children(const pugi::xml_node& node, const Context& context);
  Status visit_switch(const pugi::xml_node& node, const Context& context);
  // Visits an svg or a symbol. `sized_by`: the element whose width and height apply, itself or the `use`.
  Status visit_viewport(const pugi::xml_node& node, const pugi::xml_node& sized_by, const Context& context);
  Status visit_use(const pugi::xml_node& node, const Context& context);
  Status add_shape(const pugi::xml_node& node, std::string_view name, const Context& context);
  // Applies the element's own transform to the context. Returns false if it is malformed.
  bool enter(const pugi::xml_node& node, Context& context);
  void report_references(const pugi::xml_node& node);
  void report(const std::string& kind) { ++kinds_[kind]; }

  pugi::xml_node root_;
  Affine to_sheet_;
  std::string prefix_;  // "svg:" if the document uses such a prefix.
  std::unordered_map<std::string, pugi::xml_node> ids_;
  std::vector<pugi::xml_node> open_;  // Elements being visited, outermost first.
  cut::Path path_;
  std::size_t num_segments_ = 0;
  int num_visited_ = 0;
  std::size_t num_bytes_ = 0;   // Bytes of attributes, counted at each visit.
  bool beyond_ = false;         // Part of an outline lies outside the outermost viewport.
  Eigen::AlignedBox2d canvas_;  // The outermost viewport in the path's coordinates; empty if its size is not given.
  std::map<std::string, int> kinds_;  // Number of parts that are not cut, by kind.
  std::string first_path_error_;
};

}  // namespace kerf::svg
