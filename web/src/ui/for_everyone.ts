import { call } from '../api';
import { SheetService } from '../gen/kerf/v1/sheets_pb';
import type { Reporter } from '../notifier';
import { confirmed } from './confirmation';

/**
 * Asks before something that others see, if others watch the sheet; true if it may be done.
 * @param name        sheets/{sheet}
 * @param numStreams  streams of the sheet to this page
 * @param verb        what is done to the sheet: "Reset"
 */
export async function agreedForEveryone(
  name: string,
  numStreams: number,
  verb: string,
  reporter: Reporter,
  send: typeof call = call,
): Promise<boolean> {
  const sheet = await reporter.attempt(() => send(SheetService.method.getSheet, { name }));
  if (!sheet) return false;
  const others = sheet.viewers - numStreams;
  if (others <= 0) return true;
  const watchers = others === 1 ? 'Someone else is watching' : `${others} others are watching`;
  return confirmed(`${watchers} this sheet. ${verb} it for everyone?`, verb);
}
