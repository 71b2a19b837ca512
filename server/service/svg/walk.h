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

// Goes through a document in drawing order and gathers the outlines of what is shown.
class Walk {
 public:
  // `root`: the outermost svg element; `to_sheet`: from CSS pixels of its viewport to the path's coordinates.
  Walk(const pugi::xml_node& root, const Affine& to_sheet);

  // Once. Errors: SVG_TOO_COMPLEX, and CURVE_TOO_LONG without counting to the end.
  Status run();

  [[nodiscard]] cut::Path take_path() { return std::move(path_); }
  // For people, in the order of the alphabet.
  [[nodiscard]] std::vector<std::string> not_cut() const;

 private:
  // What an element inherits.
  struct Context {
    Affine to_sheet;
    Viewport viewport;
    bool visible = true;
    int depth = 0;  // of elements, those that `use` stands for included
  };

  // The name without the prefix; empty where the element is not SVG's.
  [[nodiscard]] std::string_view name_of(const pugi::xml_node& node) const;
  [[nodiscard]] pugi::xml_node target_of(const std::string& reference) const;

  Status index_ids();
  Status count_visit(const pugi::xml_node& node);
  Status visit(const pugi::xml_node& node, const Context& inherited);
  // What is shown of the element once its own transform and properties are in the context.
  Status visit_shown(const pugi::xml_node& node, std::string_view name, const Context& context);
  Status visit_children(const pugi::xml_node& node, const Context& context);
  Status visit_switch(const pugi::xml_node& node, const Context& context);
  // An svg or a symbol; `sized_by`: the element whose width and height hold, itself or the `use`.
  Status visit_viewport(const pugi::xml_node& node, const pugi::xml_node& sized_by, const Context& context);
  Status visit_use(const pugi::xml_node& node, const Context& context);
  Status add_shape(const pugi::xml_node& node, std::string_view name, const Context& context);
  // Whether its own transform can be told; it is then in the context.
  bool enter(const pugi::xml_node& node, Context& context);
  void report_references(const pugi::xml_node& node);
  void report(const std::string& kind) { ++kinds_[kind]; }

  pugi::xml_node root_;
  Affine to_sheet_;
  std::string prefix_;  // "svg:" where the document writes it so
  std::unordered_map<std::string, pugi::xml_node> ids_;
  std::vector<pugi::xml_node> open_;  // elements that are being visited, from the outermost on
  cut::Path path_;
  std::size_t num_segments_ = 0;
  int num_visited_ = 0;
  std::size_t num_bytes_ = 0;  // of attributes, as often as they were looked at
  bool beyond_ = false;        // something lies outside the outermost viewport
  Eigen::AlignedBox2d canvas_;
  std::map<std::string, int> kinds_;
  std::string first_path_error_;
};

}  // namespace kerf::svg
