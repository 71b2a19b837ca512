#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace kerf::mesh {

// Maps some of the ids of a mesh to numbers. Its cost depends on the number of its entries, not on the size of the
// mesh. Entries are never removed. It is a hash table with open addressing: its size is a power of two, and it is at
// most half full. The sets of core/linear/index_set.h instead reserve room for every id: they are faster, and worth it
// if kept from one edit to the next.
class IdMap {
 public:
  IdMap() : places_(kFirstSize) {}

  // Returns the number of `id`, or -1 if it is not in the map.
  [[nodiscard]] std::int32_t find(std::int32_t id) const {
    const Place& place = places_[place_of(id)];
    return place.id == id ? place.number : -1;
  }
  [[nodiscard]] bool has(std::int32_t id) const { return places_[place_of(id)].id == id; }
  // Returns the number of `id`, which must be in the map.
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
  // Adds an id as add(id, number) does; its number is its index in ids().
  bool add(std::int32_t id) { return add(id, static_cast<std::int32_t>(ids_.size())); }

  // All ids, in the order in which they were added.
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
