#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>

struct sockaddr;

namespace kerf {

// Identifies the other end of a connection, to limit connections by origin. An IPv4 address, also one mapped into IPv6,
// counts as a whole. An IPv6 address counts by its first 64 bits.
struct Peer {
  std::uint64_t high = 0;
  std::uint64_t low = 0;
  auto operator<=>(const Peer&) const = default;
};

// Returns the peer of an address. All addresses other than IPv4 and IPv6 count as one peer.
Peer peer_of(const sockaddr& address);

// Counts the connections that each peer has open. Thread-safe.
class PeerPlaces {
 public:
  // The permission for one connection of a peer; its destructor gives it back. PeerPlaces must outlive all places.
  class Place {
   public:
    ~Place();
    Place(Place&& other) noexcept;
    Place& operator=(Place&& other) noexcept;
    [[nodiscard]] const Peer& peer() const { return peer_; }

   private:
    friend class PeerPlaces;
    Place(PeerPlaces* owner, const Peer& peer) : owner_(owner), peer_(peer) {}
    PeerPlaces* owner_;  // null after this place was moved from
    Peer peer_;
  };

  // `most`: the most places that one peer may have at a time, >= 0; 0 means no limit.
  explicit PeerPlaces(int most) : most_(most) {}
  PeerPlaces(const PeerPlaces&) = delete;
  PeerPlaces& operator=(const PeerPlaces&) = delete;

  // Returns a place, or nothing if the peer has all its places already. May throw bad_alloc, and then takes no place.
  [[nodiscard]] std::optional<Place> take(const Peer& peer);
  // Returns the number of places that the peer has now.
  [[nodiscard]] int taken(const Peer& peer) const;

 private:
  void give_back(const Peer& peer);

  const int most_;
  mutable std::mutex mutex_;
  std::map<Peer, int> taken_;  // number of places of each peer that has any; guarded by mutex_
};

}  // namespace kerf
