#pragma once

#include <algorithm>
#include <cstddef>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "server/service/host/clock.h"

namespace kerf::host {

// Orders items of several groups: the group that has used the least time has the next turn. Items of a group keep their
// order. A group without items saves up no time: it begins level with the group of the last turn. A plain value.
//
// Source: start-time fair queueing (Goyal, Vin, Cheng 1996), with the time that was used in place of a length.
template <typename Item>
class FairQueue {
 public:
  class Group {
    friend class FairQueue;
    std::deque<Item> items;
    Nanoseconds used{0};
  };

  // Returns the group of a name, which lives as long as the caller keeps it or it has items.
  std::shared_ptr<Group> group(const std::string& name) {
    std::erase_if(groups_, [](const auto& each) { return each.second.expired(); });
    std::weak_ptr<Group>& known = groups_[name];
    if (std::shared_ptr<Group> found = known.lock()) return found;
    const auto made = std::make_shared<Group>();
    known = made;
    return made;
  }

  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] std::size_t size() const { return size_; }

  void push(const std::shared_ptr<Group>& group, Item item) {
    if (group->items.empty()) {
      group->used = std::max(group->used, level_);
      waiting_.push_back(group);
    }
    group->items.push_back(std::move(item));
    ++size_;
  }
  // Removes the next item; there must be one.
  Item pop() {
    const auto next = std::min_element(waiting_.begin(), waiting_.end(),
                                       [](const auto& a, const auto& b) { return a->used < b->used; });
    const std::shared_ptr<Group> group = *next;
    level_ = group->used;
    Item item = std::move(group->items.front());
    group->items.pop_front();
    if (group->items.empty()) waiting_.erase(next);
    --size_;
    return item;
  }
  // Counts time that an item of the group has used.
  void charge(Group& group, Nanoseconds time) { group.used += time; }

 private:
  std::map<std::string, std::weak_ptr<Group>> groups_;
  std::vector<std::shared_ptr<Group>> waiting_;  // Have items, in the order in which they began to have some.
  Nanoseconds level_{0};                         // Time used by the group of the last turn.
  std::size_t size_ = 0;
};

}  // namespace kerf::host
