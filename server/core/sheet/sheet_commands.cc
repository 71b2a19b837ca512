#include <variant>

#include "server/base/overloaded.h"
#include "server/core/sheet/sheet_impl.h"

namespace kerf::sheet {

Result<CommandReply> Sheet::Impl::do_command(const Command& command, const CommandContext& context) {
  moving.disturb();
  KERF_TRY(validate(command));
  const auto plain = [this](const Status& done) -> Result<CommandReply> {
    KERF_TRY(done);
    return plain_reply();
  };
  // Replies to a command that changes settings, of which viewers are notified by settings_version.
  const auto setting = [&](const Status& done) -> Result<CommandReply> {
    if (done.ok()) ++settings_version;
    return plain(done);
  };
  return std::visit(Overloaded{
                        [&](const Cut& asked) { return cut(asked, context); },
                        [&](const CutBatch& asked) { return cut_batch(asked, context); },
                        [&](const UndoCut& /*asked*/) { return undo_cut(context); },
                        [&](const RedoCut& /*asked*/) { return redo_cut(context); },
                        [&](const Grab& asked) { return plain(moving.grab(asked)); },
                        [&](const Drag& asked) { return plain(moving.drag(asked)); },
                        [&](const Release& asked) { return plain(moving.release(asked)); },
                        [&](const SetPins& asked) { return setting(moving.set_pins(asked)); },
                        [&](const SetGravity& asked) {
                          moving.set_gravity(asked.gravity);
                          return setting(Nothing{});
                        },
                        [&](const SetWind& asked) {
                          moving.set_wind(asked.wind);
                          return setting(Nothing{});
                        },
                        [&](const SetMaterial& asked) { return setting(moving.set_material(asked)); },
                        [&](const Reset& asked) {
                          reset(asked);
                          return plain(Nothing{});
                        },
                    },
                    command);
}

CommandReply Sheet::Impl::plain_reply() const {
  CommandReply reply;
  reply.topology_version = topology_version;
  reply.beginning = beginning;
  return reply;
}

}  // namespace kerf::sheet
