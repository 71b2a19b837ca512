export type NoticeKind = 'info' | 'success' | 'warning' | 'error';

/** Shows short messages to the user. */
export interface Notifier {
  /** @param details  lines that open on request */
  notify(kind: NoticeKind, text: string, details?: readonly string[]): void;
}

/** Runs calls to the server and reports those that fail. */
export interface Reporter extends Notifier {
  /**
   * Runs a call and shows its failure as a notice. Undefined if it failed.
   * @param what  begins the notice: "Nothing was cut: "
   */
  attempt<T>(run: () => Promise<T>, what?: string): Promise<T | undefined>;
}
