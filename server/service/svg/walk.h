#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include <Eigen/Geometry>
#include <pugixml.hpp>

#include "server/base/result.h"
#include "server/service/drawing/drawing.h"
#include "server/service/svg/attributes.h"
#include "server/service/svg/css_match.h"
#include "server/service/svg/paint.h"
#include "server/service/svg/path_data.h"
#include "server/service/svg/svg.h"
#include "server/service/svg/transform.h"

namespace kerf::svg {

// Visits a document in drawing order and collects the outlines of its shapes.
class Walk {
 public:
  // `root`: the outermost svg element.
  Walk(const pugi::xml_node& root, const ReadOptions& options);

  // Visits the document; to be called once. Errors: SVG_TOO_COMPLEX.
  Status run();

  [[nodiscard]] drawing::Drawing take_drawing();
  void report(const std::string& kind) { ++kinds_[kind]; }

 private:
  // Holds the state that an element inherits.
  struct Context {
    Affine to_sheet;
    Viewport viewport;
    Style style;
    std::shared_ptr<const Variables> variables;
    int group = drawing::kNoGroup;
    int group_depth = 0;
    int depth = 0;  // Nesting of elements, those that replace a `use` included.
  };

  // Returns the name without its prefix; empty if the element is not SVG's.
  [[nodiscard]] std::string_view name_of(const pugi::xml_node& node) const;
  [[nodiscard]] pugi::xml_node target_of(const std::string& reference) const;

  // Sets the size of the outermost viewport, the page and the scale.
  void lay_out(const ReadOptions& options);
  // Collects ids and style sheets of the whole document.
  Status index();
  void index_style(const pugi::xml_node& node);
  Status count_visit(const pugi::xml_node& node);
  Status visit(const pugi::xml_node& node, const Context& inherited);
  // Visits an element whose own transform and properties are already in the context.
  Status visit_content(const pugi::xml_node& node, std::string_view name, const Declared& declared,
                       const Context& context);
  Status visit_children(const pugi::xml_node& node, const Context& context);
  Status visit_switch(const pugi::xml_node& node, const Context& context);
  // Visits an svg or a symbol. `sized_by`: the element whose width and height apply, itself or the `use`.
  Status visit_viewport(const pugi::xml_node& node, const pugi::xml_node& sized_by, const Context& context);
  // Narrows canvas_ to a viewport in the outermost one, unless what lies beyond it is to be seen.
  void narrow_canvas(const pugi::xml_node& node, const Rectangle& viewport, const Context& context);
  Status visit_use(const pugi::xml_node& node, const Context& context);
  Status add_shape(const pugi::xml_node& node, std::string_view name, const Declared& declared, const Context& context);
  // Adds an outline in user units to the shape: with its dashes, transformed.
  Status add_lines(const PathData& outline, const pugi::xml_node& node, bool fixed_stroke, const Context& context,
                   drawing::Shape& shape);
  void note_extent(const cut::Subpath& line);
  // Adds the layers, classes and ids that the element begins.
  Status enter_groups(const pugi::xml_node& node, Context& context);
  // Applies the element's own transform to the context. Returns false if it is malformed.
  bool enter(const Declared& declared, Context& context);
  // Reports lengths among attributes and properties that have no meaning, such as "12,5mm" or "10vw".
  void report_lengths(const pugi::xml_node& node, const Declared& declared);
  void take_fallback(Declared& declared, Property paint) const;
  void report_references(const Declared& declared);
  [[nodiscard]] std::vector<std::string> not_cut() const;

  pugi::xml_node root_;
  Affine to_sheet_;                      // From CSS pixels of the outermost viewport to the drawing's frame.
  double pixel_ = 1.0;                   // m of a CSS pixel.
  Eigen::Vector2d root_size_{0.0, 0.0};  // CSS pixels.
  std::string prefix_;                   // "svg:" if the document uses such a prefix.
  bool has_plain_names_ = true;          // Names without a prefix are SVG's.
  std::unordered_map<std::string, pugi::xml_node> ids_;
  StyleRules rules_;
  std::optional<Cascade> cascade_;
  bool has_inkscape_layers_ = false;
  bool with_dashes_ = true;
  std::vector<pugi::xml_node> open_;  // Elements being visited, outermost first.
  drawing::Drawing drawing_;
  std::size_t num_segments_ = 0;
  int num_visited_ = 0;
  std::size_t num_bytes_ = 0;         // Bytes of attributes, counted at each visit.
  bool beyond_ = false;               // Part of a painted outline lies outside the outermost viewport.
  Eigen::AlignedBox2d canvas_;        // The outermost viewport in the drawing's frame; empty if its size is not given.
  std::map<std::string, int> kinds_;  // Number of parts that are not cut, by kind.
  std::string first_path_error_;
  std::string first_length_error_;
};

}  // namespace kerf::svg
