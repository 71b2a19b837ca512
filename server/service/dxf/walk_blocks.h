#pragma once

#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/base/result.h"
#include "server/service/drawing/affine.h"
#include "server/service/drawing/drawing.h"
#include "server/service/dxf/entity.h"

namespace kerf::dxf {

// Visits the entities of a file, with the blocks that they insert, and collects their outlines.
class BlockWalk {
 public:
  // `file` must outlive this. `scale`: m of a unit.
  BlockWalk(const File& file, double scale);

  // Visits everything; to be called once. Errors: DXF_TOO_COMPLEX.
  Status run();

  void add_note(std::string note) { drawing_.not_cut.push_back(std::move(note)); }
  [[nodiscard]] drawing::Drawing take_drawing();

 private:
  // Holds what an inserted block takes from its insertion.
  struct Context {
    drawing::Affine map;
    std::string layer;         // Layer of entities on layer 0; empty outside of blocks.
    std::uint32_t colour = 0;  // Colour of entities that take their block's.
    bool is_hidden = false;    // So is all that is inserted.
    bool is_off = false;       // The entity itself lies on a layer that is off.
    int depth = 0;
  };

  Status visit_all(const std::vector<Entity>& entities, const Context& context);
  Status visit(const Entity& entity, const std::vector<Entity>& vertices, const Context& context);
  Status insert(const Entity& entity, const Context& placed);
  Status add_shape(const Entity& entity, const std::vector<cut::Subpath>& outline, const Context& placed);
  // Returns the context with the entity's own layer, colour and visibility.
  [[nodiscard]] Context entered(const Entity& entity, const Context& context) const;
  [[nodiscard]] bool is_dashed(const Entity& entity, const std::string& layer) const;
  [[nodiscard]] int group_of(const std::string& layer);
  void report(const std::string& kind) { ++kinds_[kind]; }

  const File& file_;
  double scale_;
  drawing::Drawing drawing_;
  std::map<std::string, int> group_of_layer_;
  std::map<std::string, int> kinds_;    // Parts that are not cut, by kind.
  std::vector<std::string_view> open_;  // Blocks being visited.
  int num_visited_ = 0;
  std::size_t num_segments_ = 0;
};

}  // namespace kerf::dxf
