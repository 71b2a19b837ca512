#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace kerf::mesh {

// Maps some of the ids of a mesh to numbers, at a cost that depends on its entries and not on the mesh. Ids are only
// added. Open addressing: a power of two of places, at most half of them taken. The sets of core/linear/index_set.h
// have room for every id instead: they are faster, and worth it where they are kept from one edit to the next.
class IdMap {
 public:
  IdMap() : places_(kFirstSize) {}

  // The number of `id`, or -1.
  [[nodiscard]] std::int32_t find(std::int32_t id) const {
    const Place& place = places_[place_of(id)];
    return place.id == id ? place.number : -1;
  }
  [[nodiscard]] bool has(std::int32_t id) const { return places_[place_of(id)].id == id; }
  // `id` must be in the map.
  [[nodiscard]] std::int32_t get(std::int32_t id) const { return places_[place_of(id)].number; }

  // Adds an id with its number, both >= 0. Returns false, and changes nothing, if the map has the id already.
  bool add(std::int32_t id, std::int32_t number) {
    Place& place = places_[place_of(id)];
    if (place.id == id) return false;
    place = {id, number};
    ids_.push_back(id);
    if (2 * ids_.size() > places_.size()) grow();
    return true;
  }
  // Adds an id like the other add(), with its index in ids() as number.
  bool add(std::int32_t id) { return add(id, static_cast<std::int32_t>(ids_.size())); }

  // Ids in the order they were added in.
  [[nodiscard]] const std::vector<std::int32_t>& ids() const { return ids_; }

 private:
  struct Place {
    std::int32_t id = -1;
    std::int32_t number = -1;
  };
  static constexpr std::size_t kFirstSize = 256;

  // Returns the place of `id`, or the free place where it would be inserted.
  [[nodiscard]] std::size_t place_of(std::int32_t id) const {
    const std::size_t mask = places_.size() - 1;
    // Ids come in runs; multiplying by 2^64 / golden ratio spreads them (Knuth, vol. 3, 6.4).
    std::size_t i = (static_cast<std::uint64_t>(id) * 0x9e3779b97f4a7c15ULL >> 32) & mask;
    while (places_[i].id != id && places_[i].id >= 0) i = (i + 1) & mask;
    return i;
  }
  void grow() {
    std::vector<Place> before(2 * places_.size());
    before.swap(places_);
    for (const Place& place : before) {
      if (place.id >= 0) places_[place_of(place.id)] = place;
    }
  }

  std::vector<Place> places_;
  std::vector<std::int32_t> ids_;
};

}  // namespace kerf::mesh
