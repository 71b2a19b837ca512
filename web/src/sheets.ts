import { call } from './api';
import { SheetService, Sheet_RunState } from './gen/kerf/v1/sheets_pb';
import type { Sheet } from './gen/kerf/v1/sheets_pb';

/**
 * Returns all sheets of this server, by name.
 * @throws ApiError
 */
export async function listSheets(): Promise<Sheet[]> {
  const sheets: Sheet[] = [];
  let pageToken = '';
  do {
    const page = await call(SheetService.method.listSheets, { pageToken });
    sheets.push(...page.sheets);
    pageToken = page.nextPageToken;
  } while (pageToken !== '');
  return sheets;
}

/** sheets/demo -> demo */
export function sheetId(name: string): string {
  return name.replace(/^sheets\//, '');
}

const kRunStates: Record<Sheet_RunState, string> = {
  [Sheet_RunState.RUN_STATE_UNSPECIFIED]: 'unknown',
  [Sheet_RunState.RUNNING]: 'running',
  [Sheet_RunState.PAUSED]: 'paused',
  [Sheet_RunState.SLEEPING]: 'at rest',
  [Sheet_RunState.FAILED]: 'failed',
};

export function runStateText(state: Sheet_RunState): string {
  return kRunStates[state] ?? kRunStates[Sheet_RunState.RUN_STATE_UNSPECIFIED];
}
