import { expect, test, vi } from 'vitest';
import { Sheet_RunState } from '../src/gen/kerf/v1/sheets_pb';
import { SheetNews } from '../src/ui/sheet_news';

function news() {
  const notify = vi.fn();
  return { news: new SheetNews(notify), notify };
}

const begun = (epoch: string) => ({ epoch, hasGoneBack: false });

test('the first frame of a sheet is no news, whatever happened before', () => {
  const { news: each, notify } = news();
  each.saw('sheets/a', begun('1'), { resets: 3, resetsUndone: 1 });
  each.saw('sheets/b', begun('2'), { resets: 0, resetsUndone: 0 });
  expect(notify).not.toHaveBeenCalled();
});

test('a reset and its undo are told once each', () => {
  const { news: each, notify } = news();
  each.saw('sheets/a', begun('1'), { resets: 0, resetsUndone: 0 });
  each.saw('sheets/a', begun('1'), { resets: 1, resetsUndone: 0 });
  each.saw('sheets/a', begun('1'), { resets: 1, resetsUndone: 0 });
  expect(notify.mock.calls).toEqual([['info', expect.stringContaining('was reset')]]);
  each.saw('sheets/a', begun('1'), { resets: 1, resetsUndone: 1 });
  each.saw('sheets/a', begun('1'), { resets: 1, resetsUndone: 1 });
  expect(notify.mock.calls.slice(1)).toEqual([['info', 'The reset was undone']]);
});

test('another epoch of the same sheet says that it was made again', () => {
  const { news: each, notify } = news();
  each.saw('sheets/a', begun('1'), { resets: 2, resetsUndone: 0 });
  each.saw('sheets/a', begun('2'), { resets: 0, resetsUndone: 0 });
  expect(notify.mock.calls).toEqual([['warning', expect.stringContaining('restarted')]]);
});

test('another epoch within a stream says that it went back to a saved state', () => {
  const { news: each, notify } = news();
  each.saw('sheets/a', begun('1'), { resets: 2, resetsUndone: 0 });
  each.saw('sheets/a', { epoch: '2', hasGoneBack: true }, { resets: 1, resetsUndone: 0 });
  each.saw('sheets/a', { epoch: '2', hasGoneBack: true }, { resets: 1, resetsUndone: 0 });
  expect(notify.mock.calls).toEqual([['info', 'The sheet went back to a saved state']]);
});

test('a sheet that fails is told of once', () => {
  const { news: each, notify } = news();
  const [running, failed] = [{ runState: Sheet_RunState.RUNNING }, { runState: Sheet_RunState.FAILED }];
  each.sawSettings(running, undefined);
  each.sawSettings(failed, running);
  each.sawSettings(failed, failed);
  expect(notify.mock.calls).toEqual([['error', expect.stringContaining('frozen at its last good tick')]]);
  each.sawSettings(failed, undefined);
  expect(notify).toHaveBeenCalledTimes(2);
});
