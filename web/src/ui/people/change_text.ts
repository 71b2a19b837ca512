import type { Change } from './company';
import { personName } from './person_text';

// Texts for each call: of one, and of several in a row with # for their number. The second is often the first and
// "# times".
const kCalls: Record<string, string | readonly [once: string, often: string]> = {
  // Cuts
  CreateCut: ['cut the sheet', 'cut # times'],
  CreateCuts: ['made several cuts', 'made several cuts at once, # times'],
  ListCuts: 'looked at the cuts',
  CancelScheduledCuts: 'called off planned cuts',
  UndoCut: ['undid a change', 'undid # changes'],
  RedoCut: ['redid a change', 'redid # changes'],
  ListPieces: 'looked at the pieces',
  // Interaction
  GrabPoint: ['pulled the sheet', 'pulled # times'],
  DragPoint: 'dragged the sheet',
  ReleasePoint: 'let go of the sheet',
  SetSheetPins: 'changed the pins',
  SetSheetGravity: 'changed gravity',
  SetSheetWind: 'changed the wind',
  SetSheetMaterial: 'changed the material',
  SetSheetSelfContact: 'changed self-contact',
  // Sheets
  CreateSheet: 'made the sheet',
  UploadSheet: 'made the sheet from a file',
  GetSheet: 'looked at the settings',
  ListSheets: 'looked at the list of sheets',
  DeleteSheet: 'deleted the sheet',
  PauseSheet: ['paused the sheet', 'paused # times'],
  ResumeSheet: ['let the sheet run', 'let the sheet run # times'],
  StepSheet: ['stepped the sheet', 'stepped # times'],
  StepSheets: ['stepped several sheets', 'stepped several sheets # times'],
  ResetSheet: ['reset the sheet', 'reset # times'],
  SetSheetSpeed: 'changed the speed',
  ExportSheet: 'exported the sheet',
  GetSheetState: 'read the state',
  GetSheetRecording: 'saved the recording',
  ReplayRecording: 'played a recording',
  AnalyzeSheet: 'analysed the sheet',
  SaveState: ['saved a state', 'saved # states'],
  RestoreState: ['went back to a saved state', 'went back to saved states # times'],
  ListStates: 'looked at the saved states',
  DeleteState: ['deleted a saved state', 'deleted # saved states'],
  // Streams and pictures
  Watch: 'watched the sheet',
  Subscribe: 'read frames of the sheet',
  RenderImage: ['drew a picture', 'drew # pictures'],
  WatchImages: 'watched pictures of the sheet',
  // Files
  InspectMesh: 'looked into a mesh file',
  InspectDrawing: 'looked into a drawing',
  // The server
  GetServerInfo: 'asked about the server',
  GetAccess: 'asked about their rights',
  CreateLink: ['made a link', 'made # links'],
  GetStoreInfo: 'looked at the store',
  PruneStore: 'pruned the store',
  DeleteSetAsideSheet: 'deleted a damaged sheet',
  BackupStore: 'backed up the store',
};

/** True if people read words of their own for this call. */
export function hasWords(call: string): boolean {
  return Object.hasOwn(kCalls, call);
}

/** Splits the name of a call into words: "DoThisNow" -> "do this now". */
function splitName(call: string): string {
  return call.replaceAll(/(?<=[a-z\d])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])/g, ' ').toLowerCase();
}

/** Says what was done: "cut the sheet", "cut 7 times"; for an unknown call "called “do this now”". */
function deedText(call: string, count: number): string {
  const words = hasWords(call) ? kCalls[call] : `called “${splitName(call)}”`;
  const [once, often] = typeof words === 'string' ? [words, `${words} # times`] : words;
  if (count === 1) return once;
  return (count === 2 ? often.replace('# times', 'twice') : often).replace('#', count.toLocaleString('en'));
}

/** Says who did what: "alice cut 7 times". */
export function changeText({ tokenId, byLink, call, count }: Omit<Change, 'unixUs'>): string {
  return `${personName({ tokenId, byLink })} ${deedText(call, count)}`;
}

/** Formats the time of a change: "14:05", with its day if that is not the day of `now`: "3 May, 14:05". */
export function timeText(unixUs: bigint, now: Date): string {
  const at = new Date(Number(unixUs) / 1000);
  const clock = at.toLocaleTimeString('en-GB', { hour: '2-digit', minute: '2-digit' });
  if (at.toDateString() === now.toDateString()) return clock;
  return `${at.toLocaleDateString('en-GB', { day: 'numeric', month: 'short' })}, ${clock}`;
}
