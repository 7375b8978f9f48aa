/** A message that outlives a new start of the page. */

const NAME = "jousto-said";

export function keep(message: string): void {
  try {
    sessionStorage.setItem(NAME, message);
  } catch {
    // some browsers keep nothing
  }
}

export function kept(): string {
  try {
    const message = sessionStorage.getItem(NAME) ?? "";
    sessionStorage.removeItem(NAME);
    return message;
  } catch {
    return "";
  }
}
