#pragma once

#include <cstdint>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "tests/host/fixture.h"

namespace kerf::host {

struct Hashes {
  std::int64_t tick = 0;
  std::uint64_t state = 0;
  std::uint64_t continuation = 0;
  bool operator==(const Hashes&) const = default;
};

inline void PrintTo(const Hashes& hashes, std::ostream* out) {
  *out << "tick " << hashes.tick << ", " << std::hex << hashes.state << ", " << hashes.continuation;
}

class StatesTest : public HostTest {
 protected:
  explicit StatesTest(HostOptions options = {}) : HostTest(std::move(options)) {
    host_->set_attachments({[this](const std::string&) { return attachment_; },
                            [this](const std::string&, const std::string& bytes) { attachments_.push_back(bytes); }});
  }

  Result<SavedStateStatus> save(const std::string& id, const std::string& state, bool overwrite = false,
                                const std::string& attachment = {}) {
    Answers<SavedStateStatus> answers;
    attachment_ = attachment;
    host_->save_state(id, state, overwrite, answers.callback());
    host_->wait_idle();
    return answers.at(0);
  }
  Result<SheetStatus> restore(const std::string& id, const std::string& state) {
    Answers<SheetStatus> answers;
    host_->restore_state(id, state, answers.callback());
    host_->wait_idle();
    return answers.at(0);
  }
  std::vector<SavedStateStatus> states(const std::string& id) {
    Answers<std::vector<SavedStateStatus>> answers;
    host_->states(id, answers.callback());
    host_->wait_idle();
    return answers.at(0).value();
  }
  std::string forget(const std::string& id, const std::string& state) {
    Answers<Nothing> answers;
    host_->delete_state(id, state, answers.callback());
    host_->wait_idle();
    return answers.reason(0);
  }
  Hashes hashes(const std::string& id) {
    Hashes found;
    Answers<Nothing> answers;
    host_->inspect(
        id,
        [&](const sheet::Sheet& sheet) {
          found = {sheet.tick(), sheet.state_hash(), sheet.continuation_hash()};
        },
        answers.callback());
    host_->wait_idle();
    return found;
  }
  std::string pause(const std::string& id) {
    Answers<SheetStatus> answers;
    host_->pause(id, answers.callback());
    host_->wait_idle();
    return answers.reason(0);
  }
  std::int64_t schedule(const std::string& id, scene::Command command, std::int64_t at_tick) {
    Answers<std::int64_t> answers;
    host_->schedule(id, std::move(command), at_tick, answers.callback());
    host_->wait_idle();
    return answers.at(0).value();
  }

  void step(const std::string& id, std::int64_t ticks) {
    Answers<SheetStatus> stepped;
    host_->step(id, ticks, stepped.callback());
    host_->wait_idle();
    ASSERT_EQ(stepped.reason(0), "done");
  }

  // Commands to a paused sheet one after another, each with ticks after it, and where they lead.
  std::vector<Hashes> play(const std::string& id) {
    std::vector<Hashes> seen;
    const std::vector<scene::Command> commands{
        scenes::line_cut({-0.1, 0.31}, {1.1, 0.62}),
        scene::UndoCut{},
        scenes::circle_cut({0.4, 0.4}, 0.15),
        scene::UndoCut{},
        scene::UndoCut{},  // Undoes a cut made before the state was saved.
        scene::RedoCut{},
        scene::SetGravity{{0.5, 0.0, -9.0}},
        scene::Grab{"hand", 3, std::nullopt, 50.0},
        scene::Drag{"hand", {0.2, 0.1, 0.3}},
        scene::Reset{},
    };
    for (const scene::Command& command : commands) {
      const Result<CommandResult> result = submit(id, command);
      EXPECT_TRUE(result.ok()) << command.index() << ": " << result.error().reason;
      step(id, 3);
      seen.push_back(hashes(id));
    }
    return seen;
  }

  std::string attachment_;  // Saved with the next state.
  std::vector<std::string> attachments_;
};

}  // namespace kerf::host
