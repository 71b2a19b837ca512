#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "server/core/scene/sheet_config.h"

// Scenes in which sheets touch themselves: what self-contact is held to. SI units, gravity 9.81 m/s^2, a floor at z = 0
// unless said, friction 0.3. The material has E h = 1000 N/m, 0.2 kg/m^2 and a thickness of 0.5 mm. Scenes with `side`
// have side x side vertices on 1 m x 1 m; side is 8..200.
namespace kerf::scenes {

inline constexpr std::int32_t kSelfContactSide = 50;

// a: stands on its lower edge 1 cm above the floor, leans by 5 % of its height and has a wave of 2 cm.
scene::SheetConfig falls_on_edge(std::int32_t side = kSelfContactSide);
// b: horizontal, held at one corner, without a floor.
scene::SheetConfig hung_by_corner(std::int32_t side = kSelfContactSide);
// c: folded twice along mesh lines: four layers, three thicknesses apart, the lowest as far above the floor. Edges at
// the folds start with strains of up to 3 %.
scene::SheetConfig folded_twice(std::int32_t side = kSelfContactSide);
// d: as a, in five strips from top to bottom whose lips coincide.
scene::SheetConfig falls_in_strips(std::int32_t side = kSelfContactSide);
// e: a strip of 1 m x 0.04 m in free space, `columns` (12..400) x 5 vertices. Its ends turn against each other by four
// turns in 4 s while they approach by 0.25 m, and are held then.
scene::SheetConfig twisted_strip(std::int32_t columns = 98);
// f: two pieces of side x side / 2 vertices. One lies on the floor; one 5 cm above falls onto it at 10 m/s. Both start
// with that speed, as an initial velocity is that of the whole sheet: the floor stops the lower one in the first
// substep.
scene::SheetConfig thrown_on_a_layer(std::int32_t side = kSelfContactSide);
// s: ten pieces of side x side (2..200) vertices, 0.3 m x 0.3 m, 1 cm apart, the lowest 1 cm above the floor.
scene::SheetConfig stack_of_ten(std::int32_t side = 16);
// p: as a, with four slits of 0.6 m cut into the pile at tick 48.
scene::SheetConfig cut_in_the_pile(std::int32_t side = kSelfContactSide);
// r: the demo's cloth, free and horizontal 0.8 m above the floor, after `cuts` random cuts at tick 1.
scene::SheetConfig falls_after_cuts(std::int32_t side = kSelfContactSide, std::uint64_t seed = 14159265,
                                    std::size_t cuts = 50);

// w: hung by its upper edge at 45 degrees and let go. It swings, and nothing comes near anything.
scene::SheetConfig swings(std::int32_t side = kSelfContactSide);

struct SelfContactScene {
  char letter;
  const char* name;
  double seconds;                      // to run it for, s
  bool has_layers;                     // its pieces lie one on another, in the order of their labels from the lowest up
  scene::SheetConfig (*make)();        // at full size
  scene::SheetConfig (*make_small)();  // for tests
};

// All of them, in the order above.
std::span<const SelfContactScene> self_contact_scenes();

}  // namespace kerf::scenes
