import { create } from '@bufbuild/protobuf';
import { beforeEach, describe, expect, it } from 'vitest';
import { SelfContact_Mode } from '../src/gen/kerf/v1/scene_pb';
import { SheetSchema } from '../src/gen/kerf/v1/sheets_pb';
import type { Reporter } from '../src/notifier';
import { SelfContactControl } from '../src/ui/physics/self_contact_control';
import { fakePage } from './support/fake_page';
import type { FakeElement } from './support/fake_page';
import { HeldCalls } from './support/held_calls';

describe('self-contact', () => {
  let server: HeldCalls;
  let page: (id: string) => FakeElement;
  let control: SelfContactControl;

  beforeEach(() => {
    page = fakePage();
    server = new HeldCalls();
    const live = { sheetName: 'sheets/a', refresh: async () => {} };
    const reporter: Reporter = { attempt: (run) => run(), notify: () => {} };
    control = new SelfContactControl(live, reporter);
  });

  const turn = (isOn: boolean) => {
    page('self-contact-on').checked = isOn;
    page('self-contact-on').dispatchEvent(new Event('input'));
  };
  const show = (selfContact?: { mode: SelfContact_Mode; friction?: number }) =>
    control.show(create(SheetSchema, { scene: { selfContact } }));
  const sent = () => server.calls.map(({ method, request }) => [method, request.setSelfContact]);

  it('is off, with the default friction, where the scene does not have it', () => {
    show();
    expect(page('self-contact-on').checked).toBe(false);
    expect(page('self-contact-friction-value').textContent).toBe('0.30');
  });

  it('shows what is in force', () => {
    show({ mode: SelfContact_Mode.ON, friction: 0 });
    expect(page('self-contact-on').checked).toBe(true);
    expect(page('self-contact-friction').value).toBe('0');
    show({ mode: SelfContact_Mode.OFF, friction: 0.5 });
    expect(page('self-contact-on').checked).toBe(false);
    expect(page('self-contact-friction-value').textContent).toBe('0.50');
  });

  it('is turned on with the friction that it shows, also one beyond the slider', () => {
    show({ mode: SelfContact_Mode.OFF, friction: 7 });
    turn(true);
    expect(sent()).toEqual([['SetSheetSelfContact', { mode: 'ON', friction: 7 }]]);
  });

  it('stays on or off when its friction changes', async () => {
    show({ mode: SelfContact_Mode.ON, friction: 0.3 });
    page('self-contact-friction').enter('0.8', 'input');
    await server.answer();
    turn(false);
    expect(sent()).toEqual([
      ['SetSheetSelfContact', { mode: 'ON', friction: 0.8 }],
      ['SetSheetSelfContact', { mode: 'OFF', friction: 0.8 }],
    ]);
  });

  it('does not jump back while the server does not have the newest setting yet', () => {
    show();
    turn(true);
    show();
    expect(page('self-contact-on').checked).toBe(true);
  });
});
