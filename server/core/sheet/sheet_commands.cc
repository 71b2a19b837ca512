#include <variant>

#include "server/base/overloaded.h"
#include "server/core/sheet/sheet_impl.h"

namespace kerf::sheet {

Result<scene::CommandReply> Sheet::Impl::do_command(const scene::Command& command, const CommandContext& context) {
  moving.disturb();
  KERF_TRY(validate(command));
  const auto plain = [this](const Status& done) -> Result<scene::CommandReply> {
    KERF_TRY(done);
    return plain_reply();
  };
  // Replies to a command that changes settings, of which viewers are notified by settings_version.
  const auto setting = [&](const Status& done) -> Result<scene::CommandReply> {
    if (done.ok()) ++settings_version;
    return plain(done);
  };
  return std::visit(Overloaded{
                        [&](const scene::Cut& asked) { return cut(asked, context); },
                        [&](const scene::CutBatch& asked) { return cut_batch(asked, context); },
                        [&](const scene::UndoCut& /*asked*/) { return undo_cut(context); },
                        [&](const scene::RedoCut& /*asked*/) { return redo_cut(context); },
                        [&](const scene::Grab& asked) { return plain(moving.grab(asked)); },
                        [&](const scene::Drag& asked) { return plain(moving.drag(asked)); },
                        [&](const scene::Release& asked) { return plain(moving.release(asked)); },
                        [&](const scene::SetPins& asked) { return setting(moving.set_pins(asked)); },
                        [&](const scene::SetGravity& asked) {
                          moving.set_gravity(asked.gravity);
                          return setting(Nothing{});
                        },
                        [&](const scene::SetWind& asked) {
                          moving.set_wind(asked.wind);
                          return setting(Nothing{});
                        },
                        [&](const scene::SetMaterial& asked) { return setting(moving.set_material(asked)); },
                        [&](const scene::SetSelfContact& asked) { return setting(moving.set_self_contact(asked)); },
                        [&](const scene::Reset& asked) {
                          reset(asked);
                          return plain(Nothing{});
                        },
                    },
                    command);
}

scene::CommandReply Sheet::Impl::plain_reply() const {
  scene::CommandReply reply;
  reply.topology_version = topology_version;
  reply.beginning = beginning;
  return reply;
}

}  // namespace kerf::sheet
